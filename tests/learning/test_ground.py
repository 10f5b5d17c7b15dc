"""The ground as robots ask for it is that of the blocks: MuJoCo's rays judge, and each library agrees."""

from __future__ import annotations

import pickle
from collections.abc import Iterator
from copy import deepcopy
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rsegen
from rsegen import Ground, Pit, Random, Recipe
from rsegen.errors import ParameterError, TooLarge
from rsegen.learning.patterns import scan_points

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")
adapter = pytest.importorskip("rsegen.learning.mujoco")

FRICTION = (0.2, 0.4, 0.6, 0.8, 0.9)
RECIPE = Recipe(
    seed=7,
    chunk_size=6,
    chunks=(1, 2),
    unit_cm=5,
    boundary="none",
    level_friction=FRICTION,
    obstacles=[Random(levels=6)],
)
POS = (1.0, 2.0, 0.5)
WORLDS = 5
LEVELS = rsegen.build_many(RECIPE, range(WORLDS))
GROUND = Ground(RECIPE, LEVELS, POS)


def _points(count: int, seed: int = 0) -> np.ndarray:
    """Points of each world on its map and around it, (worlds, count, 2)."""
    return np.random.default_rng(seed).uniform((0.5, 1.2), (1.5, 2.8), (WORLDS, count, 2))


def _rays(model: Any, points: np.ndarray) -> Iterator[tuple[float, float]]:
    """Heights at which rays straight down end, and the friction coefficient of the geom there."""
    data, geom = mujoco.MjData(model), np.zeros(1, dtype=np.int32)
    mujoco.mj_forward(model, data)
    for point in points:
        way = mujoco.mj_ray(model, data, [*point, 5.0], [0, 0, -1], None, 1, -1, geom)
        yield 5.0 - way, model.geom_friction[geom[0], 0]


def _with_plane(friction: float, height: float) -> Any:
    spec = mujoco.MjSpec()
    plane = mujoco.mjtGeom.mjGEOM_PLANE
    spec.worldbody.add_geom(type=plane, size=[0, 0, 1], pos=[0, 0, height - 1e-9], friction=[friction, 0, 0])
    return spec


def test_rays_of_mujoco_end_on_the_ground_of_each_world() -> None:
    grid, spec = adapter.BlockGrid(RECIPE, pos=POS), _with_plane(RECIPE.friction, POS[2])
    grid.add_to(spec)
    model, points = spec.compile(), _points(200)
    ground = grid.ground(LEVELS)
    for levels, places, *asked in zip(LEVELS, points, ground.heights(points), ground.friction(points), strict=True):
        grid.write(model, levels)
        assert np.transpose(list(_rays(model, places))) == pytest.approx(np.array(asked), abs=1e-8)
    assert len(np.unique(np.rint(ground.heights(points) / 0.05))) == 6


def test_rays_of_mujoco_end_on_the_ground_of_a_scene_with_frames() -> None:
    framed = replace(RECIPE, boundary="divided", frame_height_cm=12, frame_friction=0.1)
    scene, spec = rsegen.compose(framed, 3), _with_plane(framed.friction, POS[2])
    adapter.add_map(spec, scene, POS)
    ground = Ground.of(scene, POS)
    half = np.array(scene.field.extent) / 2 + 0.1
    points = np.random.default_rng(1).uniform(-half, half, (300, 2)) + POS[:2]
    asked = np.array([ground.heights(points), ground.friction(points)])
    assert np.transpose(list(_rays(spec.compile(), points))) == pytest.approx(asked, abs=1e-8)
    assert (asked[1] == 0.1).sum() > 20
    assert ground.field() == scene.field
    assert np.array_equal(ground.levels, scene.field.levels)
    x, y, z, _ = ground.spots((0.3, 0.3))[0]
    assert ground.highest([x, y], 0.149) == pytest.approx(z)
    with pytest.raises(ParameterError, match="levels: the ground is that of one field; make a Ground from a recipe"):
        ground.write(scene.field.levels)


@given(st.integers(0, WORLDS - 1), st.integers(0, 6), st.integers(0, 12), st.floats(-1e-6, 1e-6))
def test_an_edge_has_the_height_of_the_higher_block(world: int, i: int, j: int, beside: float) -> None:
    around = np.pad(LEVELS[world], 1)
    corner = [POS[0] + (i - 3) * 0.1 + beside, POS[1] + (j - 6) * 0.1 - beside]
    highest = around[i : i + 2, j : j + 2].max()
    assert GROUND.heights([corner], worlds=[world])[0] == pytest.approx(POS[2] + highest * 0.05)
    coefficient = [RECIPE.friction, *FRICTION][highest]
    assert GROUND.friction([corner], worlds=[world])[0] == pytest.approx(coefficient)


@given(st.integers(0, 10**6), st.floats(0.0, 0.4))
def test_no_block_under_a_square_is_missed(seed: int, radius: float) -> None:
    x, y = np.random.default_rng(seed).uniform((0.5, 1.2), (1.5, 2.8))
    around = np.pad(LEVELS[0], 20)
    i, j = (np.arange(cells) - cells / 2 for cells in around.shape)
    near_x, near_y = (
        (at + (edges + 1) * 0.1 >= place - radius - 1e-5) & (at + edges * 0.1 <= place + radius + 1e-5)
        for at, edges, place in ((POS[0], i, x), (POS[1], j, y))
    )
    expected = POS[2] + around[np.ix_(near_x, near_y)].max() * 0.05
    assert GROUND.highest([[x, y]], radius, worlds=[0])[0] == pytest.approx(expected)


def test_a_normal_is_that_of_the_plane_of_least_squares() -> None:
    points = _points(20)
    normals = GROUND.normals(points, 0.17)
    offsets = np.linspace(-0.17, 0.17, 5)
    grid = np.stack(np.meshgrid(offsets, offsets, indexing="ij"), axis=-1).reshape(-1, 2)
    for world, index in np.ndindex(WORLDS, 20):
        heights = GROUND.heights(points[world, index] + grid, worlds=[world] * 25)
        a, b, _ = np.linalg.lstsq(np.column_stack([grid, np.ones(25)]), heights, rcond=None)[0]
        assert normals[world, index] == pytest.approx(np.array([-a, -b, 1]) / np.sqrt(a * a + b * b + 1))
    assert np.abs(normals[..., :2]).max() > 0.1


def test_a_scan_turns_with_the_robot() -> None:
    pattern = scan_points((0.4, 0.2), 0.1)
    assert pattern.shape == (15, 2)
    poses = np.concatenate([_points(1)[:, 0], np.random.default_rng(2).uniform(0.5, 3, (WORLDS, 2))], axis=1)
    scans = GROUND.scan(pattern, poses)
    for world, (x, y, z, yaw) in enumerate(poses):
        turned = pattern @ np.array([[np.cos(yaw), np.sin(yaw)], [-np.sin(yaw), np.cos(yaw)]]) + np.array([x, y])
        assert scans[world] == pytest.approx(GROUND.heights(turned[None], worlds=[world])[0] - z)


def test_a_robot_at_whole_metres_scans_all_of_its_pattern() -> None:
    pattern = scan_points((0.4, 0.2), 0.1)
    pose = [[1, 2, 0, 1]] * WORLDS
    assert np.array_equal(GROUND.scan(pattern, pose), GROUND.scan(pattern, np.array(pose, dtype=float)))


@pytest.mark.parametrize("ground", [GROUND, Ground.of(rsegen.compose(RECIPE))])
def test_a_copy_for_another_process_is_the_same_ground(ground: Ground) -> None:
    for again in (pickle.loads(pickle.dumps(ground)), deepcopy(ground)):  # noqa: S301  # our own
        points = _points(20) if ground.worlds else _points(20)[0]
        assert np.array_equal(again.heights(points), ground.heights(points))
        assert np.array_equal(again.friction(points), ground.friction(points))
    if ground.worlds:
        again.write(0 * LEVELS)
        assert ground.levels.any()


def test_points_of_half_precision_are_where_those_of_double_precision_are() -> None:
    points = _points(2000).astype(np.float16)
    assert np.array_equal(GROUND.heights(points), GROUND.heights(points.astype(float)))
    assert GROUND.heights(points).dtype == float


@pytest.mark.parametrize("name", ["torch", "jax.numpy"])
def test_a_ground_on_a_device_is_copied_for_another_process(name: str) -> None:
    library = pytest.importorskip(name, reason=f"{name} is not installed")
    points = library.asarray(_points(20).astype(np.float32))
    ground = Ground(RECIPE, library.asarray(LEVELS), POS)
    for again in (pickle.loads(pickle.dumps(ground)), deepcopy(ground)):  # noqa: S301  # our own
        assert np.array_equal(np.asarray(again.heights(points)), np.asarray(ground.heights(points)))


def test_levels_of_jax_are_of_any_sort_of_integers() -> None:
    jnp = pytest.importorskip("jax.numpy", reason="jax is not installed")
    assert np.array_equal(np.asarray(Ground(RECIPE, jnp.asarray(LEVELS, dtype="int32"), POS).levels), LEVELS)


def test_a_lifted_robot_touches_the_ground_with_its_lowest_foot() -> None:
    feet = np.concatenate([_points(4), np.random.default_rng(3).uniform(0, 2, (WORLDS, 4, 1))], axis=-1)
    feet[..., 2] += GROUND.lift(feet, 0.03)[:, None]
    above = feet[..., 2] - GROUND.highest(feet, 0.03)
    assert above.min(axis=1) == pytest.approx(0, abs=1e-12)


def test_spots_are_on_the_most_level_ground() -> None:
    level_place = rsegen.build_many(replace(RECIPE, seed=8), range(WORLDS))
    level_place[:, 2:5, 3:6] = 4
    ground = Ground(RECIPE, level_place, POS)
    spots = ground.spots((0.3, 0.3), seed=1)
    assert spots.shape == (WORLDS, 1, 4)
    assert spots[..., :3] == pytest.approx(np.broadcast_to((1.05, 1.85, 0.7), (WORLDS, 1, 3)))
    many = ground.spots((0.25, 0.15), 20, seed=1)
    assert np.array_equal(many, ground.spots((0.25, 0.15), 20, seed=1))
    assert not np.array_equal(many, ground.spots((0.25, 0.15), 20, seed=2))
    for world in range(WORLDS):
        windows = np.lib.stride_tricks.sliding_window_view(level_place[world], (3, 2))
        uneven = np.ptp(windows.astype(int), axis=(2, 3))
        i = np.rint((many[world, :, 0] - POS[0]) / 0.1 + 1.5).astype(int)
        j = np.rint((many[world, :, 1] - POS[1]) / 0.1 + 5).astype(int)
        assert sorted(uneven[i, j]) == sorted(uneven.ravel())[:20]
        assert many[world, :, 2] == pytest.approx(POS[2] + 0.05 * windows[i, j].max(axis=(1, 2)))
    assert set(np.rint(spots[..., 3].ravel() * 2 / np.pi)) <= {0, 1, 2, 3}
    assert set(np.rint(many[..., 3].ravel() * 2 / np.pi)) == {0, 2}


def test_spots_are_not_in_holes() -> None:
    gap = Pit(levels=4, gap_width=3, first=(0, 0), last=(9, 9))
    pit = Recipe(seed=1, boundary="none", ground_level=4, obstacles=[gap])
    ground = Ground(pit, rsegen.build_many(pit, range(3)))
    assert ground.levels.min() == 1
    assert (ground.spots((0.1, 0.1), 10)[..., 2] >= 4 * ground.unit - 1e-6).all()


def test_written_maps_are_in_their_worlds_alone() -> None:
    ground, points = Ground(RECIPE, LEVELS, POS), _points(50)
    new = rsegen.build_many(RECIPE, range(100, 102))
    ground.write(new, worlds=[4, 1])
    expected = LEVELS.copy()
    expected[[4, 1]] = new
    assert np.array_equal(ground.levels, expected)
    assert np.array_equal(ground.heights(points), Ground(RECIPE, expected, POS).heights(points))
    assert np.array_equal(ground.heights(points[:2], worlds=[4, 1]), Ground(RECIPE, new, POS).heights(points[:2]))
    assert np.array_equal(ground.field(4).heights, rsegen.build(RECIPE, 100).heights)
    ground.write(LEVELS)
    assert np.array_equal(ground.levels, LEVELS)
    ground.write(LEVELS[:0], worlds=[])  # no robot begins anew
    ground.write(LEVELS[3:5], worlds=range(3, 5))
    assert np.array_equal(ground.levels, LEVELS)


def test_a_point_that_is_no_number_is_outside() -> None:
    assert GROUND.heights(np.full((WORLDS, 1, 2), np.nan)).tolist() == [[POS[2]]] * WORLDS
    assert GROUND.heights(np.full((WORLDS, 1, 2), np.inf)).tolist() == [[POS[2]]] * WORLDS
    assert Ground(RECIPE, LEVELS[0], outside=3).heights([9.0, 9.0]) == pytest.approx(0.15)


def _answers(ground: Ground, array: Any) -> list[Any]:
    """Every question about the ground, asked with arrays of a library."""
    feet = np.concatenate([_points(30), np.full((WORLDS, 30, 1), 0.6)], axis=-1).astype(np.float32)
    poses = np.concatenate([feet[:, 0], np.full((WORLDS, 1), 0.3, dtype=np.float32)], axis=-1)
    return [
        ground.heights(array(feet)),
        ground.friction(array(feet)),
        ground.normals(array(feet), 0.2),
        ground.scan(scan_points((0.4, 0.2)), array(poses)),
        ground.lift(array(feet), 0.03),
        ground.lift(array(feet[:2]), 0.03, worlds=[3, 1]),
        ground.spots((0.3, 0.3), 4),
    ]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["torch", "jax.numpy"])
def test_torch_and_jax_agree_with_numpy(name: str) -> None:
    library = pytest.importorskip(name, reason=f"{name} is not installed")
    ground = Ground(RECIPE, library.asarray(LEVELS), POS)
    for expected, found in zip(_answers(GROUND, np.asarray), _answers(ground, library.asarray), strict=True):
        assert type(found) is type(library.zeros(1))
        assert np.asarray(found) == pytest.approx(expected, abs=1e-6)
    ground.write(library.asarray(LEVELS[:2]), worlds=[2, 0])
    assert np.array_equal(np.asarray(ground.levels)[[2, 0]], LEVELS[:2])
    ground.write(library.asarray(LEVELS[3:]), worlds=library.asarray(np.array([2, 0], dtype=np.uint8)))
    assert np.array_equal(np.asarray(ground.levels)[[2, 0]], LEVELS[3:])


@pytest.mark.slow
def test_jax_compiles_the_ground_of_a_world() -> None:
    jax = pytest.importorskip("jax", reason="jax is not installed")
    compiled = jax.jit(jax.vmap(lambda levels, points: Ground(RECIPE, levels, POS).heights(points)))
    points = _points(30).astype(np.float32)
    assert np.asarray(compiled(LEVELS, points)) == pytest.approx(GROUND.heights(points), abs=1e-6)


@pytest.mark.long(reason="Warp, 0.4 GB")
def test_arrays_of_warp_are_viewed() -> None:
    wp = pytest.importorskip("warp", reason="Warp is not installed")
    points = _points(30).astype(np.float32)
    ground = Ground(RECIPE, wp.array(LEVELS, dtype=wp.int16, device="cpu"), POS)
    found = ground.heights(wp.array(points, dtype=wp.vec2, device="cpu"))
    assert np.array_equal(found, GROUND.heights(points))


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (
            lambda: Ground(replace(RECIPE, boundary="outer"), LEVELS),
            r"boundary: 'outer' has frames; use none, or",
        ),
        (lambda: Ground(RECIPE, LEVELS * 0.05), "levels: of float64; expected integers, in units"),
        (lambda: Ground(RECIPE, LEVELS + 1), r"levels: 1..6 are not all in 0..5, the levels of the recipe"),
        (lambda: Ground(RECIPE, LEVELS[0, 0]), r"levels: of shape \(12,\); expected \(n_x, n_y\)"),
        (lambda: Ground(RECIPE, {1: LEVELS}), "levels: .* is not an array of numpy, torch, jax or Warp"),
        (lambda: Ground(RECIPE, LEVELS, outside=6), "outside: level 6 is outside 0..5"),
        (lambda: GROUND.heights(np.zeros((3, 2))), r"points: of shape \(3, 2\) for 5 worlds; expected \(5, ..., 2\)"),
        (lambda: GROUND.heights(np.zeros((5, 1))), r"points: of shape \(5, 1\); expected \(..., 2\)"),
        (lambda: GROUND.heights("here"), "points: 'here' is not an array"),
        (lambda: GROUND.lift(np.zeros((5, 4, 2))), r"points: of shape \(5, 4, 2\); expected \(..., 3\)"),
        (lambda: GROUND.heights(np.zeros((1, 2)), worlds=0), "worlds: 0 is not a list of indices of worlds"),
        (lambda: GROUND.write(LEVELS, np.ones(5, dtype=bool)), r"worlds: array\(.*\) is not a list of indices"),
        (lambda: GROUND.heights(np.zeros((1, 2)), worlds=[5]), r"worlds: 5..5 are not all in 0..4"),
        (lambda: Ground(RECIPE, LEVELS[0]).heights(np.zeros(2), worlds=[0]), "worlds: .* is of one map; leave it out"),
        (lambda: GROUND.write(LEVELS[:2]), r"levels: of shape \(2, 6, 12\); expected \(5, 6, 12\)"),
        (lambda: GROUND.write(LEVELS[:2], worlds=[0]), r"levels: of shape \(2, 6, 12\); expected \(1, 6, 12\)"),
        (lambda: GROUND.normals(np.zeros((5, 2)), 0), "radius: 0 m; use one above 0"),
        (lambda: GROUND.normals(np.zeros((5, 2)), np.inf), "radius: inf m; use one above 0"),
        (lambda: GROUND.highest(np.zeros((5, 2)), np.full(5, 0.1)), r"radius: of shape \(5,\); expected a number, or"),
        (lambda: GROUND.spots((2, 0.3)), "size: 2 x 0.3 m is larger than the map of 6 x 12 blocks"),
        (lambda: GROUND.spots((0.3, 0.3), 41), "count: 41 is outside 1..40"),
        (lambda: GROUND.spots((0.3, 0.3), 0), "count: 0 is not 1 or more"),
        (lambda: GROUND.spots((0.3,)), r"size: \(0.3,\) is not 2 values, each 0..1000 m"),
        (lambda: GROUND.spots(np.array([-0.3, 0.3])), r"size\[0\]: -0.3 is outside 0..1000 m"),
        (lambda: Ground(RECIPE, LEVELS, (1, 2)), r"pos: \(1, 2\) is not x, y and z in metres"),
        (lambda: Ground(RECIPE, LEVELS, (1, 2, np.inf)), r"pos: \(1, 2, inf\) is not x, y and z in metres"),
        (lambda: Ground(RECIPE, LEVELS, outside=1.5), "outside: level 1.5 is outside 0..5"),  # type: ignore[arg-type]
        (lambda: Ground(RECIPE, [[1, 2], [3]]), "levels: .* is not an array of numpy, torch, jax or Warp"),
        (lambda: GROUND.highest(np.zeros((5, 2)), -0.1), "radius: -0.1 m; use 0 or more"),
        (lambda: GROUND.highest(np.zeros((5, 2)), np.nan), "radius: nan m; use 0 or more"),
        (lambda: GROUND.highest(np.zeros((5, 2)), np.array([0.1, np.inf])), "radius: inf m; use 0 or more"),
        (
            lambda: GROUND.scan(np.zeros((4, 2)), np.zeros((5, 7))),
            r"poses: of shape \(5, 7\); expected \(..., 4\), of which",
        ),
        (lambda: GROUND.scan([0.1, 0.2], np.zeros((5, 4))), r"pattern: of shape \(2,\); expected \(points, 2\)"),
        (lambda: GROUND.lift(np.zeros((5, 0, 3))), r"points: of shape \(5, 0, 3\); expected \(..., points, 3\)"),
        (lambda: GROUND.lift([0.0, 0.0, 1.0]), r"points: of shape \(3,\); expected \(..., points, 3\), one at"),
        (lambda: GROUND.field(5), "world: 5 is outside 0..4"),
        (lambda: scan_points((1, 1), 0), "distance: 0 is outside 0.001..1000 m"),
        (lambda: scan_points((-1, 1)), r"size\[0\]: -1 is outside 0..1000 m"),
    ],
)
def test_impossible_values_are_refused(ask: Any, message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        ask()


def test_more_worlds_than_memory_are_refused() -> None:
    endless = np.broadcast_to(LEVELS[:1], (2**45, 6, 12))
    with pytest.raises(TooLarge, match="levels: 35184372088832 maps of 6 x 12 blocks are more than this machine's"):
        Ground(RECIPE, endless)
