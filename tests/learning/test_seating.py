"""Robots are put on blocks by what MuJoCo says: a hair above them, or at rest on them, their joints as they were."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rsegen
from rsegen import Random, Recipe
from rsegen.errors import ParameterError

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")
from rsegen.learning.mujoco import BlockGrid, add_map  # noqa: E402  # it needs MuJoCo
from rsegen.learning.seating import CLEARANCE, seat, seat_many  # noqa: E402  # the same

RECIPE = Recipe(seed=3, chunk_size=40, unit_cm=3, boundary="none", obstacles=[Random(levels=5)])
WORLDS = 12
LEVELS = rsegen.build_many(RECIPE, range(WORLDS))

LEGS = """
<mujoco>
  <default><geom contype="0" conaffinity="1" condim="1"/></default>
  <worldbody>
    <body name="trunk" pos="0 0 0.6">
      <freejoint/>
      <geom type="box" size="0.2 0.1 0.05" mass="5"/>
      {legs}
    </body>
    <body name="ball" pos="1 1 1"><freejoint/><geom size="0.04" mass="0.2"/></body>
  </worldbody>
  <actuator>{motors}</actuator>
</mujoco>"""
LEG = """
<body pos="{x} {y} 0">
  <joint name="hip{i}" axis="0 1 0" range="-1 1" limited="true"/>
  <geom type="capsule" fromto="0 0 0 0 0 -0.2" size="0.02"/>
  <body pos="0 0 -0.2">
    <joint name="knee{i}" axis="0 1 0"/>
    <geom type="capsule" fromto="0 0 0 0 0 -0.2" size="0.02"/>
    <geom type="ellipsoid" pos="0 0 -0.22" size="0.04 0.02 0.03"/>
  </body>
</body>"""
CART = """
<mujoco>
  <worldbody>
    <body pos="0 0 0.5">
      <joint type="slide" axis="1 0 0"/><joint name="up" type="slide" axis="0 0 1"/><joint type="hinge" axis="0 1 0"/>
      <geom type="box" size="0.3 0.1 0.05" mass="2"/>
      <body pos="0.2 0 -0.05"><joint axis="0 1 0"/><geom type="cylinder" size="0.08 0.02" euler="90 0 0"/></body>
      <body pos="-0.2 0 -0.05"><joint axis="0 1 0"/><geom type="cylinder" size="0.08 0.02" euler="90 0 0"/></body>
    </body>
  </worldbody>
</mujoco>"""


def _legged() -> str:
    places = [(x, y) for x in (0.18, -0.18) for y in (0.12, -0.12)]
    legs = "".join(LEG.format(i=i, x=x, y=y) for i, (x, y) in enumerate(places))
    return LEGS.format(legs=legs, motors='<motor joint="knee0"/>')


def _model(text: str, grid: BlockGrid) -> Any:
    spec = mujoco.MjSpec.from_string(text)
    grid.add_to(spec)
    return spec.compile()


def _depths(model: Any, grid: BlockGrid, levels: np.ndarray, qpos: np.ndarray) -> np.ndarray:
    """Depth of each contact of a robot with the blocks."""
    grid.write(model, levels)
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    mujoco.mj_forward(model, data)
    first = model.geom(grid.names[0]).id
    pairs = data.contact.geom
    return -data.contact.dist[((pairs >= first) & (pairs < first + len(grid.names))).any(axis=1)]  # type: ignore[no-any-return]


def _positions(model: Any, seed: int = 0) -> np.ndarray:
    """Positions of the joints of each world: at any place and heading, with any bend of the joints."""
    rng, many = np.random.default_rng(seed), np.tile(model.qpos0, (WORLDS, 1))
    free = model.jnt_type == mujoco.mjtJoint.mjJNT_FREE
    for at in model.jnt_qposadr[free]:
        turn = rng.uniform(-np.pi, np.pi, WORLDS)
        many[:, at : at + 2] += rng.uniform(-0.5, 0.5, (WORLDS, 2))
        many[:, at + 3], many[:, at + 6] = np.cos(turn / 2), np.sin(turn / 2)
    bent = model.jnt_qposadr[model.jnt_type == mujoco.mjtJoint.mjJNT_HINGE]
    many[:, bent] += rng.uniform(-0.3, 0.3, (WORLDS, len(bent)))
    return many


@pytest.mark.parametrize("text", [_legged(), CART], ids=["legs", "a cart in a plane"])
def test_robots_of_worlds_are_a_hair_above_the_blocks(text: str) -> None:
    grid = BlockGrid(RECIPE)
    model = _model(text, grid)
    given = _positions(model)
    seated, rests = seat_many(model, given, grid.ground(LEVELS), grid)
    assert not rests.any()
    roots = [2, 7 + 8 + 2] if model.nq > 10 else [1]
    others = [at for at in range(model.nq) if at not in roots]
    assert np.array_equal(seated[:, others], given[:, others])
    for world, qpos in enumerate(seated):
        assert not (_depths(model, grid, LEVELS[world], qpos) > 0).any()
        for root in roots:
            lower = qpos.copy()
            lower[root] -= CLEARANCE + 3e-4
            assert (_depths(model, grid, LEVELS[world], lower) > 0).any()
    assert np.ptp(seated[:, roots[0]]) > 0.03  # the worlds differ


@pytest.mark.slow
def test_robots_that_are_dropped_rest_and_keep_their_joints() -> None:
    grid = BlockGrid(RECIPE)
    model = _model(_legged(), grid)
    given = _positions(model)
    placed, _ = seat_many(model, given, grid.ground(LEVELS), grid)
    rested, rests = seat_many(model, given, grid.ground(LEVELS), grid, seconds=10)
    assert rests.mean() > 0.7
    joints = slice(7, 7 + 8)
    assert np.abs(rested[:, joints] - given[:, joints]).max() < 1e-4
    assert model.dof_armature.max() == 0
    for world in np.flatnonzero(rests):
        depths = _depths(model, grid, LEVELS[world], rested[world])
        assert len(depths) >= 4  # three feet and a ball
        assert depths.max() < 2e-3
        assert rested[world, 2] < placed[world, 2] + 1e-3


BOX = '<geom type="box" size="0.09 0.09 0.05"/>'
SLIDES = {
    "down": (-1, f'<body><joint type="slide" axis="0 0 -1"/>{BOX}</body>'),
    "along y of a body that is turned": (
        1,
        '<body euler="90 0 0"><joint type="slide" axis="0 1 0"/><geom type="box" size="0.09 0.05 0.09"/></body>',
    ),
    "on a body that slides aside": (
        1,
        f"""<body><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><joint type="slide" axis="1 0 0"/>
        <body><joint type="slide" axis="0 0 1"/>{BOX}</body></body>""",
    ),
    "on a body that turns about z": (
        1,
        f"""<body><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><joint type="hinge"/>
        <body><joint type="slide" axis="0 0 1" ref="0.7"/>{BOX}</body></body>""",
    ),
}


@pytest.mark.parametrize(("upwards", "robot"), SLIDES.values(), ids=SLIDES.keys())
def test_whatever_slides_along_the_z_of_the_world_is_put_on_the_blocks(upwards: int, robot: str) -> None:
    grid = BlockGrid(RECIPE, pos=(0.1, 0, 0.4))
    model = _model(f"<mujoco><worldbody>{robot}</worldbody></mujoco>", grid)
    for levels in LEVELS[:4]:
        grid.write(model, levels)
        data, ground = mujoco.MjData(model), grid.ground(levels)
        seat(model, data, ground)
        bottom = data.geom_xpos[0, 2] - 0.05
        assert bottom == pytest.approx(ground.highest([0.0, 0.0], 0.09) + CLEARANCE, abs=2e-4)
        assert data.qpos[-1] - model.qpos0[-1] == pytest.approx(upwards * (bottom + 0.05))


@pytest.mark.parametrize(
    "robot",
    [
        f'<body euler="90 0 0"><joint type="slide" axis="0 0 1"/>{BOX}</body>',  # along the y of the world
        f'<body>{BOX}<body><joint type="slide" axis="0 0 1"/>{BOX}</body></body>',  # a lift of what stands
        f'<body><joint axis="1 0 0"/>{BOX}<body><joint type="slide" axis="0 0 1"/>{BOX}</body></body>',
    ],
    ids=["aside", "lift", "tilting"],
)
def test_what_does_not_raise_the_whole_robot_stays_as_it_is(robot: str) -> None:
    grid = BlockGrid(RECIPE, pos=(0, 0, 0.4))
    model = _model(f"<mujoco><worldbody>{robot}</worldbody></mujoco>", grid)
    grid.write(model, LEVELS[0])
    data = mujoco.MjData(model)
    seat(model, data, grid.ground(LEVELS[0]))
    assert np.array_equal(data.qpos, model.qpos0)


def test_a_mesh_is_put_as_near_to_the_blocks_as_its_vertices_let_it() -> None:
    """The box around this tetrahedron is tilted, as its principal axes are, and reaches far below it."""
    asset = '<asset><mesh name="corner" vertex="0 0 0 0.2 0 0 0 0.2 0 0 0 0.2"/></asset>'
    robot = '<body pos="0 0 1"><freejoint/><geom type="mesh" mesh="corner"/></body>'
    grid = BlockGrid(RECIPE)
    model = _model(f"<mujoco>{asset}<worldbody>{robot}</worldbody></mujoco>", grid)
    rng = np.random.default_rng(0)
    for levels in LEVELS:
        given = model.qpos0.copy()
        given[3:7] = rng.normal(size=4)
        seated, _ = seat_many(model, given[None], grid.ground(levels[None]), grid)
        assert not (_depths(model, grid, levels, seated[0]) > 0).any()
        seated[0, 2] -= CLEARANCE + 3e-4
        assert (_depths(model, grid, levels, seated[0]) > 0).any()


def test_one_robot_is_put_on_a_map_that_is_compiled() -> None:
    scene, spec = rsegen.compose(RECIPE, 5), mujoco.MjSpec.from_string(_legged())
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 1])
    add_map(spec, scene)
    model = spec.compile()
    data = mujoco.MjData(model)
    data.qpos[:2], data.qvel[:], data.time = (0.33, -0.21), 3.0, 7.0
    assert not seat(model, data, rsegen.Ground.of(scene))
    assert data.time == 7
    assert not data.qvel.any()
    assert not (data.contact.dist < 0).any()
    before = data.qpos.copy()
    assert seat(model, data, rsegen.Ground.of(scene), seconds=10)
    assert data.qpos[2] < before[2]
    assert data.ncon >= 3


def test_a_model_without_blocks_is_put_above_the_boxes_around_its_geoms() -> None:
    model = mujoco.MjModel.from_xml_string(CART)
    data = mujoco.MjData(model)
    ground = rsegen.Ground(RECIPE, LEVELS[0], pos=(0, 0, 2))
    assert not seat(model, data, ground)
    wheel = 0.5 - 0.05 - 0.08 + data.qpos[1]
    assert wheel == pytest.approx(2 + CLEARANCE + ground.highest([[0.2, 0.0], [-0.2, 0.0]], 0.0).max() - 2, abs=0.13)
    assert wheel > 2


def test_what_does_not_fit_is_refused() -> None:
    grid = BlockGrid(RECIPE)
    model = _model(CART, grid)
    with pytest.raises(ParameterError, match=r"qpos: of shape \(5,\); expected \(robots, 5\)"):
        seat_many(model, model.qpos0, grid.ground(LEVELS[0]))
    with pytest.raises(ParameterError, match=r"seconds: nan is not a finite number"):
        seat_many(model, model.qpos0[None], grid.ground(LEVELS[0]), seconds=np.nan)
    with pytest.raises(ParameterError, match=r"qpos\[1, 2\]: nan is not a finite number"):
        seat_many(model, np.where(np.arange(10).reshape(2, 5) == 7, np.nan, 0), grid.ground(LEVELS[0]))
    with pytest.raises(ParameterError, match="ground: 1 robots on the ground of 12 worlds; use as many of both"):
        seat_many(model, model.qpos0[None], grid.ground(LEVELS), grid)
    with pytest.raises(ParameterError, match="ground: 12 robots on the ground of 12 worlds; use as many"):
        seat_many(model, np.tile(model.qpos0, (12, 1)), grid.ground(LEVELS))


GO1 = Path(sys.prefix) / "mjlab" / "mjlab" / "asset_zoo" / "robots" / "unitree_go1" / "xmls" / "go1.xml"


@pytest.mark.long(reason="needs mjlab")
def test_no_foot_of_go1_is_in_a_block_on_any_tile() -> None:
    if not GO1.is_file():
        pytest.skip(f"no mjlab in {GO1.parents[5]}: make learners puts it there")
    course = rsegen.Terrain(recipes=RECIPE, rows=3, columns=2, border=10)
    spec = mujoco.MjSpec.from_file(str(GO1))
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 1])
    add_map(spec, rsegen.compose(course.recipe))
    model = spec.compile()
    data, ground = mujoco.MjData(model), rsegen.Ground(course.recipe, course.field.levels)
    rested = 0
    for x, y, _ in course.origins.reshape(-1, 3):
        data.qpos[:] = model.qpos0
        data.qpos[:2], data.qpos[7:] = (x, y), np.tile([0, 0.9, -1.8], 4)
        seat(model, data, ground)
        assert not (data.contact.dist < 0).any()
        rested += seat(model, data, ground, seconds=5)
    assert rested > 4
