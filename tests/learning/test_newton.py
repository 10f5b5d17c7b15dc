"""A map in Newton: its shapes are the map's boxes or surface, each with its own friction."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from rsegen import Matrix, Random, Recipe, build_many, compose, scan_points
from rsegen.errors import ParameterError, UnknownName
from tests.support.late_import import LateImport
from tests.support.long import long_unless
from tests.support.policy_step import learn

newton = LateImport("newton", reason="Newton is not installed")
wp = LateImport("warp", reason="Warp is not installed")
adapter = LateImport("rsegen.learning.newton", reason="Newton is not installed")

pytestmark = pytest.mark.long(reason="Newton, with Warp 0.5 GB")

SCENE = compose(
    Recipe(
        seed=3,
        chunk_size=6,
        unit_cm=5,
        boundary="none",
        level_friction=(0.2, 0.4, 0.6),
        obstacles=[Random(levels=4)],
    )
)


@pytest.mark.parametrize("shape", ["boxes", "mesh"])
def test_every_level_has_its_friction(shape: str) -> None:
    builder = newton.ModelBuilder()
    shapes = adapter.add_map(builder, SCENE, shape=shape)
    frictions = {round(builder.shape_material_mu[number], 6) for number in shapes}
    assert frictions == {0.2, 0.4, 0.6}
    assert builder.body_count == 0
    assert (len(shapes) == 3) == (shape == "mesh")
    assert builder.finalize(device="cpu").shape_count == len(shapes)


def test_boxes_are_the_heights_of_the_cells() -> None:
    builder = newton.ModelBuilder()
    shapes = adapter.add_map(builder, SCENE, pos=(1, 2, 0.5))
    found = np.zeros(SCENE.field.shape)
    x, y = ((edges[:-1] + edges[1:]) / 2 for edges in SCENE.field.edges())
    for number in shapes:
        centre, half = (
            np.array(builder.shape_transform[number][:3]) - (1, 2, 0.5),
            np.array(builder.shape_scale[number]),
        )
        inside = np.ix_(np.abs(x - centre[0]) < half[0], np.abs(y - centre[1]) < half[1])
        assert not found[inside].any()
        assert centre[2] - half[2] == pytest.approx(0, abs=1e-6)
        found[inside] = centre[2] + half[2]
    assert np.allclose(found, SCENE.field.heights, atol=1e-6)


def test_an_unknown_shape_is_refused() -> None:
    with pytest.raises(UnknownName, match=r"unknown shape 'hfield' .*boxes, mesh"):
        adapter.add_map(newton.ModelBuilder(), SCENE, shape="hfield")


WORLDS = 3
RECIPE = replace(SCENE.recipe, seed=7, chunk_size=4)


@cache
def grid() -> Any:
    """The blocks that worlds have."""
    return adapter.BlockGrid(RECIPE, pos=(1, 2, 0.5))


def _worlds() -> tuple[Any, np.ndarray]:
    """A model of worlds with the blocks and a ball above the block (2, 1) in each, and the shapes of the blocks."""
    one = newton.ModelBuilder()
    shapes = np.array(grid().add_to(one))
    ball = one.add_body(xform=wp.transform(wp.vec3(1.05, 1.95, 0.8), wp.quat_identity()))
    one.add_shape_sphere(ball, radius=0.03)
    builder = newton.ModelBuilder()
    builder.replicate(one, WORLDS)
    return builder.finalize(device="cpu"), shapes + one.shape_count * np.arange(WORLDS)[:, None]


def test_blocks_change_in_a_finalized_model() -> None:
    model, shapes = _worlds()
    levels = build_many(RECIPE, range(WORLDS))
    grid().write(model, levels, shapes)
    places, sizes, friction = (
        array.numpy()[shapes] for array in (model.shape_transform, model.shape_scale, model.shape_material_mu)
    )
    heights = levels.reshape(WORLDS, -1) * 0.05
    assert np.allclose(places[..., 2] + sizes[..., 2], 0.5 + heights)
    assert np.allclose(places[..., 3:], (0, 0, 0, 1))
    middles = (np.arange(4) - 1.5) * 0.1
    assert np.allclose(places[0, :, 0].reshape(4, 4), 1 + middles[:, None])
    assert np.allclose(places[0, :, 1].reshape(4, 4), 2 + middles)
    assert np.allclose(sizes[..., :2], 0.05)
    assert np.allclose(friction, grid().sliding(levels))
    ground = grid().ground(levels)
    assert np.allclose(ground.heights(places[..., :2]), places[..., 2] + sizes[..., 2])
    assert np.allclose(ground.friction(places[..., :2]), friction)
    before = model.shape_scale.numpy()
    grid().write(model, levels[0], shapes[2])
    after = model.shape_scale.numpy()
    assert np.array_equal(after[shapes[2]], before[shapes[0]])
    assert np.array_equal(after[shapes[:2]], before[shapes[:2]])
    grid().write(model, levels[:0], shapes[:0])  # no world begins anew
    assert np.array_equal(model.shape_scale.numpy(), after)


def test_other_shapes_are_refused() -> None:
    model, shapes = _worlds()
    with pytest.raises(ParameterError, match="shapes: 32 for 16 blocks; pass those of add_to"):
        grid().write(model, build_many(RECIPE, [0])[0], shapes[:2])
    with pytest.raises(ParameterError, match=r"shapes: 1000..1015 of 51 shapes"):
        grid().write(model, build_many(RECIPE, [0])[0], shapes[0] + 1000)


def _later(model: Any, stepper: Any, now: Any, steps: int) -> Any:
    """The state after steps of 2 ms; XPBD is given its contacts, MuJoCo finds them itself."""
    control, following = model.control(), model.state()
    pipeline = newton.CollisionPipeline(model) if isinstance(stepper, newton.solvers.SolverXPBD) else None
    contacts = pipeline.contacts() if pipeline else None
    for _ in range(steps):
        now.clear_forces()
        if pipeline:
            pipeline.collide(now, contacts)
        stepper.step(now, following, control, contacts, 0.002)
        now, following = following, now
    return now


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:set_const_:DeprecationWarning")  # Newton calls it
@pytest.mark.parametrize("solver", ["SolverXPBD", "SolverMuJoCo"])
def test_balls_rest_on_the_blocks_written_last(solver: str) -> None:
    if solver == "SolverMuJoCo":
        pytest.importorskip("mujoco_warp", reason="mujoco_warp is not installed")
    model, shapes = _worlds()
    stepper = getattr(newton.solvers, solver)(model)
    for first in (0, 10):
        levels = build_many(RECIPE, range(first, first + WORLDS))
        grid().write(model, levels, shapes)
        stepper.notify_model_changed(newton.ModelFlags.SHAPE_PROPERTIES)
        now = model.state()
        newton.eval_fk(model, model.joint_q, model.joint_qd, now)
        now = _later(model, stepper, now, 300)
        assert now.body_q.numpy()[:, 2] == pytest.approx(0.53 + levels[:, 2, 1] * 0.05, abs=0.002)


@pytest.mark.slow
def test_a_policy_that_pushes_balls_over_blocks_learns_a_step() -> None:
    torch = pytest.importorskip("torch", reason="PyTorch is not installed: it is a download of gigabytes")
    model, shapes = _worlds()
    levels = build_many(RECIPE, range(WORLDS))
    grid().write(model, levels, shapes)
    stepper = newton.solvers.SolverXPBD(model)
    stepper.notify_model_changed(newton.ModelFlags.SHAPE_PROPERTIES)
    now, following, control = model.state(), model.state(), model.control()
    newton.eval_fk(model, model.joint_q, model.joint_qd, now)
    now = _later(model, stepper, now, 300)
    assert now.body_q.numpy()[:, 2] == pytest.approx(0.53 + levels[:, 2, 1] * 0.05, abs=0.002)
    ground, pattern = grid().ground(levels), scan_points((0.2, 0.2), 0.1)
    pipeline = newton.CollisionPipeline(model)
    contacts = pipeline.contacts()

    def observe() -> Any:
        place = now.body_q.numpy()[:, :3]
        scan = ground.scan(pattern, np.column_stack([place, np.zeros(WORLDS)]))
        return torch.from_numpy(np.hstack([place, now.body_qd.numpy(), scan]))

    def act(forces: Any) -> Any:
        """Push the balls, of 0.1 kg, along x and y for 0.02 s; the reward is their velocity along x."""
        nonlocal now, following
        pushes = np.zeros((WORLDS, 6), dtype=np.float32)
        pushes[:, :2] = 0.5 * forces
        for _ in range(10):
            now.body_f.assign(pushes)
            pipeline.collide(now, contacts)
            stepper.step(now, following, control, contacts, 0.002)
            now, following = following, now
        return torch.from_numpy(now.body_qd.numpy()[:, 0].copy())

    observed, rewards = learn(observe, act, 2, steps=8)
    assert len(torch.unique(observed[0, :, -len(pattern) :].round(decimals=2))) >= 4  # heights of blocks
    assert rewards.abs().max() > 0.05


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:set_const_:DeprecationWarning")  # Newton calls it
@pytest.mark.parametrize(
    ("solver", "ground", "least", "most"),
    long_unless(
        lambda case: case[1] == "boxes",
        [
            ("SolverMuJoCo", "blocks", 0.98, 1.01),
            ("SolverXPBD", "boxes", 0.98, 1.01),
            # A box catches on the seams of blocks; docs/frameworks.md says so.
            ("SolverXPBD", "blocks", 0.5, 0.9),
        ],
        reason="another solver or ground",
    ),
)
def test_boxes_slide_as_far_as_the_friction_of_their_level_lets_them(
    solver: str, ground: str, least: float, most: float
) -> None:
    """By v^2 / (2 mu g), on `blocks` of a grid or on the `boxes` of a map; world k is level at level k + 1."""
    if solver == "SolverMuJoCo":
        pytest.importorskip("mujoco_warp", reason="mujoco_warp is not installed")
    friction, builder, shapes = np.array([0.2, 0.4, 0.6]), newton.ModelBuilder(), []
    blocks = adapter.BlockGrid(replace(RECIPE, chunk_size=12))
    levels = np.ones((3, 12, 12), dtype=np.int16) * np.arange(1, 4, dtype=np.int16)[:, None, None]
    for level in (1, 2, 3):
        world = newton.ModelBuilder()
        if ground == "blocks":
            shapes.append(np.array(blocks.add_to(world)) + builder.shape_count)
        else:
            matrix = Matrix(rows=(" ".join([str(level)] * 12),) * 12)
            adapter.add_map(world, compose(replace(blocks.recipe, obstacles=(matrix,))))
        box = world.add_body(xform=wp.transform(wp.vec3(-0.5, 0.02, 0.05 * level + 0.02), wp.quat_identity()))
        # The solvers combine two frictions in different ways, which all give the same for two equal ones.
        material = newton.ModelBuilder.ShapeConfig(mu=float(friction[level - 1]))
        world.add_shape_box(box, hx=0.08, hy=0.06, hz=0.02, cfg=material)
        builder.add_world(world)
    model = builder.finalize(device="cpu")
    if ground == "blocks":
        blocks.write(model, levels, np.array(shapes))
    own = {"njmax": 512, "nconmax": 256} if solver == "SolverMuJoCo" else {}
    stepper, now = getattr(newton.solvers, solver)(model, **own), model.state()
    speeds = np.zeros((3, 6), dtype=np.float32)
    speeds[:, 0] = 1.5
    now.joint_qd.assign(speeds.ravel())
    newton.eval_fk(model, now.joint_q, now.joint_qd, now)
    now = _later(model, stepper, now, 430)
    share = (now.body_q.numpy()[:, 0] + 0.5) / (1.5**2 / (2 * friction * 9.81))
    assert least < share.min() <= share.max() < most
    assert np.abs(now.body_qd.numpy()).max() < 0.01
