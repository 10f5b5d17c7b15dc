"""Blocks that change in place are the compiled map, contact by contact."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import rsegen
from rsegen import Ground, Random, Recipe
from rsegen.errors import ParameterError
from rsegen.recipe.examples import EXAMPLES

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")
adapter = pytest.importorskip("rsegen.learning.mujoco")

RECIPE = Recipe(
    seed=7,
    chunk_size=6,
    chunks=(1, 2),
    unit_cm=5,
    boundary="none",
    level_friction=(0.2, 0.4, 0.6, 0.8, 0.9),
    level_colours=("#ff0000",),
    obstacles=[Random(levels=6)],
)
RADIUS = 0.03


def _with_ball(spec: Any) -> tuple[Any, Any]:
    """A model with a free ball that has no friction of its own."""
    body = spec.worldbody.add_body(name="ball", pos=[0, 0, 2])
    body.add_freejoint()
    body.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[RADIUS, 0, 0], friction=[0, 0, 0])
    model = spec.compile()
    return model, mujoco.MjData(model)


def _contacts(model: Any, state: Any, x: float, y: float, z: float) -> list[tuple[float, ...]]:
    """Depth, place and friction of each contact of the ball there."""
    state.qpos[:] = [x, y, z, 1, 0, 0, 0]
    mujoco.mj_forward(model, state)
    found = state.contact[: state.ncon]
    return sorted((round(c.dist, 9), *np.round(c.pos, 9).tolist(), round(float(c.friction[0]), 9)) for c in found)


def test_each_cell_of_a_written_map_is_that_of_the_compiled_one() -> None:
    grid, spec = adapter.BlockGrid(RECIPE), mujoco.MjSpec()
    grid.add_to(spec)
    model, state = _with_ball(spec)
    for index, levels in enumerate(rsegen.build_many(RECIPE, range(4))):
        grid.write(model, levels)
        of_its_own = mujoco.MjSpec()
        adapter.add_map(of_its_own, rsegen.compose(RECIPE, index))
        ground = {"type": mujoco.mjtGeom.mjGEOM_PLANE, "size": [0, 0, 1], "friction": [RECIPE.friction, 0.005, 0.0001]}
        of_its_own.worldbody.add_geom(**ground)
        compiled, other = _with_ball(of_its_own)
        for i, j in np.ndindex(*levels.shape):
            x, y = (i - 2.5) * 0.1, (j - 5.5) * 0.1
            for lifted in (-0.001, 0.001):
                at = x, y, levels[i, j] * 0.05 + RADIUS + lifted
                assert _contacts(model, state, *at) == _contacts(compiled, other, *at)
            assert len(_contacts(model, state, x, y, levels[i, j] * 0.05 + RADIUS - 0.001)) == 1


def test_a_ball_rests_on_the_blocks_written_last() -> None:
    grid, spec = adapter.BlockGrid(RECIPE, pos=(1, 2, 0.5)), mujoco.MjSpec()
    grid.add_to(spec)
    model, state = _with_ball(spec)
    for level in (5, 0, 3):
        grid.write(model, np.full(grid.shape, level))
        mujoco.mj_resetData(model, state)
        state.qpos[:3] = [1.05, 2.05, 0.5 + level * 0.05 + 0.1]
        mujoco.mj_step(model, state, 1000)
        assert state.qpos[2] == pytest.approx(0.5 + level * 0.05 + RADIUS, abs=0.001)


@pytest.mark.parametrize("compiler", ["", '<compiler fusestatic="true"/>'])
def test_blocks_touch_after_constants_were_computed_on_a_lower_map(compiler: str) -> None:
    """MuJoCo 4.0 then looks for contacts no higher than that map, and training draws masses at each reset."""
    body = '<body pos="3 3 3"><geom size="0.1"/><geom size="0.1" pos="0.3 0 0"/></body>'
    grid = adapter.BlockGrid(RECIPE, pos=(0.5, 0, 0.2))
    spec = mujoco.MjSpec.from_string(f"<mujoco>{compiler}<worldbody>{body}</worldbody></mujoco>")
    grid.add_to(spec)
    model, state = _with_ball(spec)
    levels = rsegen.build_many(RECIPE, [0])[0]
    low = np.zeros(grid.shape, dtype=int)
    expected, found = list[Any](), list[Any]()
    for contacts in (expected, found):
        grid.write(model, levels)
        for i, j in np.ndindex(*levels.shape):
            x, y, top = 0.5 + (i - 2.5) * 0.1, (j - 5.5) * 0.1, 0.2 + levels[i, j] * 0.05
            contacts.append([_contacts(model, state, x, y, top + RADIUS - depth) for depth in (0.001, 0.05)])
        grid.write(model, low)
        mujoco.mj_setConst(model, state)
    assert all(touching for pair in expected for touching in pair)
    assert found == expected


@pytest.mark.parametrize("fused", ["true", "false"])
def test_blocks_are_where_the_ground_is_if_the_compiler_fuses_static_bodies(fused: str) -> None:
    """As it does for URDF: by rays on each block."""
    grid = adapter.BlockGrid(RECIPE, pos=(1, 2, 0.5))
    spec = mujoco.MjSpec.from_string(f'<mujoco><compiler fusestatic="{fused}"/></mujoco>')
    grid.add_to(spec)
    model, state = _with_ball(spec)
    assert model.nbody == (2 if fused == "true" else 3)
    for levels in rsegen.build_many(RECIPE, range(3)):
        grid.write(model, levels)
        state.qpos[:3] = 0, 0, -9
        mujoco.mj_forward(model, state)
        ground = grid.ground(levels)
        for i, j in np.ndindex(*levels.shape):
            x, y = 1 + (i - 2.5) * 0.1, 2 + (j - 5.5) * 0.1
            assert 2 - _ray(model, state, x, y) == pytest.approx(ground.heights([x, y]), abs=1e-9)
            assert ground.heights([x, y]) == pytest.approx(0.5 + levels[i, j] * 0.05)


def test_arrays_of_many_maps_equal_the_arrays_of_each_map() -> None:
    grid, many = adapter.BlockGrid(RECIPE), rsegen.build_many(RECIPE, range(3))
    for array in (grid.pos, grid.size, grid.rgba, grid.friction):
        assert array(many).shape[:2] == (3, 72)
        assert np.array_equal(array(many)[2], array(many[2]))
        assert array(many[:0]).shape == (0, *array(many).shape[1:])
    assert grid.rgba(np.ones(grid.shape, dtype=int))[0].tolist() == [1, 0, 0, 1]


def test_a_map_has_no_mass() -> None:
    spec = mujoco.MjSpec()
    body = adapter.add_map(spec, rsegen.compose(RECIPE, 0), pos=(0, 0, 1))
    model = spec.compile()
    assert model.body_mass.sum() == 0
    assert model.body(body.name).pos.tolist() == [0, 0, 1]


def test_a_place_that_is_none_is_refused_of_maps_and_terrains() -> None:
    terrain = rsegen.Terrain(recipes=replace(RECIPE, level_friction=None), rows=1, columns=1)
    for add, what in ((adapter.add_map, rsegen.compose(RECIPE, 0)), (adapter.add_terrain, terrain)):
        with pytest.raises(ParameterError, match=r"pos: \(1, 2\) is not x, y and z in metres"):
            add(mujoco.MjSpec(), what, pos=(1, 2))


def test_values_that_a_grid_cannot_hold_are_refused() -> None:
    with pytest.raises(ParameterError, match="boundary: 'divided' has frames"):
        adapter.BlockGrid(Recipe(seed=1))
    with pytest.raises(ParameterError, match=r"levels: of shape \(3, 3\) for a grid of \(6, 12\)"):
        adapter.BlockGrid(RECIPE).pos(np.zeros((3, 3), dtype=int))
    with pytest.raises(ParameterError, match=r"levels: 6..6 are not all in 0..5, the levels of the recipe"):
        adapter.BlockGrid(RECIPE).pos(np.full((6, 12), 6))
    with pytest.raises(ParameterError, match=r"pos: \(1, 2\) is not x, y and z in metres"):
        adapter.BlockGrid(RECIPE, pos=(1, 2))
    with pytest.raises(ParameterError, match=r"pos: \(nan, 0, 0\) is not x, y and z in metres"):
        adapter.BlockGrid(RECIPE, pos=(np.nan, 0, 0))
    with pytest.raises(ParameterError, match=r"levels: of shape \(2, 3, 3\) for a grid of \(6, 12\)"):
        adapter.BlockGrid(RECIPE).ground(np.zeros((2, 3, 3), dtype=int))


@pytest.mark.parametrize("name", ["pos", "size", "rgba", "sliding", "friction"])
def test_no_array_of_blocks_is_made_of_levels_that_are_none(name: str) -> None:
    array = getattr(adapter.BlockGrid(RECIPE), name)
    for levels, message in (
        (np.full((6, 12), -1), r"levels: -1..-1 are not all in 0..5"),
        (np.full((6, 12), 6), r"levels: 6..6 are not all in 0..5"),
        (np.zeros((6, 12)), "levels: of float64; expected integers"),
        (np.zeros((12, 6), dtype=int), r"levels: of shape \(12, 6\) for a grid of \(6, 12\)"),
    ):
        with pytest.raises(ParameterError, match=message):
            array(levels)


@pytest.mark.parametrize(
    ("made", "message"),
    [
        (lambda: adapter.BlockGrid("rubble"), "recipe: 'rubble' is not a recipe, which rsegen.load reads"),
        (lambda: adapter.BlockGrid(RECIPE, contact=3), "contact: 3 is not a Contact of rsegen.scene.contact"),
        (lambda: adapter.BlockGrid(RECIPE).add_to(mujoco.MjSpec().compile()), "spec: .* is not a MjSpec of mujoco"),
        (lambda: adapter.add_map(mujoco.MjSpec(), RECIPE), "scene: .* is not a scene, which rsegen.compose makes"),
        (lambda: adapter.add_terrain(mujoco.MjSpec(), RECIPE), "terrain: .* is not a Terrain of rsegen.learning"),
        (lambda: Ground.of("rubble"), "scene: .* is not a scene, which rsegen.compose makes"),  # type: ignore[arg-type]
    ],
)
def test_a_value_of_another_class_is_refused_with_what_makes_one(made: Callable[[], Any], message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        made()


def test_what_is_not_written_leaves_the_model_as_it_was() -> None:
    grid, spec = adapter.BlockGrid(RECIPE), mujoco.MjSpec()
    grid.add_to(spec)
    model, _ = _with_ball(spec)
    levels = rsegen.build_many(RECIPE, range(2))
    grid.write(model, levels[0])
    names = ("geom_pos", "geom_size", "geom_rgba", "geom_friction")
    before = {name: getattr(model, name).copy() for name in names}
    smaller, larger = (adapter.BlockGrid(replace(RECIPE, chunk_size=size)) for size in (4, 8))
    other = adapter.BlockGrid(RECIPE, name="other")
    refused: list[tuple[Callable[[], None], str]] = [
        (lambda: grid.write(model, levels[1] * 1.0), "levels: of float64; expected integers, in units"),
        (lambda: grid.write(model, levels[1] * np.nan), "levels: of float64; expected integers, in units"),
        (lambda: grid.write(model, levels), r"levels: of shape \(2, 6, 12\); expected \(6, 12\), as a model has one"),
        (lambda: grid.write(model, levels[1] + 5), r"levels: 5..10 are not all in 0..5"),
        (lambda: smaller.write(model, smaller.highest), "model: has no geom block_3_7 where this grid has its last"),
        (lambda: larger.write(model, larger.highest), "model: has no geom block_7_15 where this grid has its last"),
        (lambda: other.write(model, levels[1]), r"model: has no geom other_0_0; add the blocks by grid\.add_to"),
    ]
    for write, message in refused:
        with pytest.raises(ParameterError, match=message):
            write()
    assert all(np.array_equal(getattr(model, name), values) for name, values in before.items())


def test_rays_find_every_block_and_hole_of_a_deck() -> None:
    recipe = rsegen.load(EXAMPLES["stairs-and-stones"])
    field, spec = rsegen.build(recipe), mujoco.MjSpec()
    adapter.add_map(spec, rsegen.compose(recipe))
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 1])
    grid = adapter.BlockGrid(recipe, pos=(0, 10, 0))
    grid.add_to(spec)
    model = spec.compile()
    grid.write(model, field.levels)
    state = mujoco.MjData(model)
    mujoco.mj_forward(model, state)
    x, y = (edges[:-1] + field.block_width / 2 for edges in field.edges())
    for at_y in (0, 10):
        tops = np.array([[2 - _ray(model, state, i, j + at_y) for j in y] for i in x])
        assert np.allclose(tops, field.heights, atol=1e-9)
    assert np.unique(field.levels).tolist() == [0, 5, 6, 7, 8, 9, 10]


def _ray(model: Any, state: Any, x: float, y: float) -> float:
    """The way down to the first geom from a height of 2 m."""
    hit = np.zeros(1, dtype=np.int32)
    return float(mujoco.mj_ray(model, state, np.array([x, y, 2.0]), np.array([0, 0, -1.0]), None, 1, -1, hit, None))
