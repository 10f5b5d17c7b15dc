"""Robots of Gymnasium and of MuJoCo Menagerie touch blocks, stand on them and rub on them, whatever their defaults say.

Menagerie is not a package: RSEGEN_MENAGERIE names a folder that has it, or a part of it.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rsegen
from rsegen import Random, Recipe
from rsegen.errors import ParameterError
from rsegen.formats.mjcf import Mjcf
from tests.formats.maps import made

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")
gymnasium = pytest.importorskip("gymnasium", reason="Gymnasium is not installed")
from rsegen.learning.mujoco import BlockGrid, add_map, add_terrain, geom_bounds, roots_of  # noqa: E402  # it needs MuJoCo
from rsegen.scene.contact import Contact  # noqa: E402

FRICTIONS = (0.35, 0.45, 0.55, 0.65, 0.75)
RECIPE = Recipe(
    seed=1,
    chunk_size=30,
    unit_cm=5,
    block_width_cm=20,
    boundary="none",
    friction=0.3,
    level_friction=FRICTIONS,
    obstacles=[Random(levels=6)],
)
LEVEL, TOP, FRICTION = 3, 0.15, 0.55
GYMNASIUM = sorted((Path(gymnasium.__file__).parent / "envs" / "mujoco" / "assets").glob("*.xml"))
MENAGERIE = (
    "agility_cassie/cassie",
    "anybotics_anymal_b/anymal_b",
    "anybotics_anymal_c/anymal_c",
    "franka_emika_panda/panda",
    "kuka_iiwa_14/iiwa14",
    "rethink_robotics_sawyer/sawyer",
    "robotiq_2f85/2f85",
    "robotis_op3/op3",
    "shadow_hand/left_hand",
    "shadow_hand/right_hand",
    "unitree_a1/a1",
    "unitree_go1/go1",
    "universal_robots_ur5e/ur5e",
    "wonik_allegro/left_hand",
    "wonik_allegro/right_hand",
)
STAND = {"agility_cassie/cassie", "anybotics_anymal_b/anymal_b", "anybotics_anymal_c/anymal_c", "robotis_op3/op3"} | {
    "unitree_a1/a1",
    "unitree_go1/go1",
    "ant",
    "half_cheetah",
    "hopper",
    "humanoid",
    "humanoidstandup",
    "walker2d",
    "walker2d_v5",
}
"""Robots that can fall, so that they have to rest on the blocks; the others hang where they are."""

HOSTILE = """
<default>
  <geom contype="0" conaffinity="0" condim="1" priority="9" friction="3 2 1" margin="0.05" gap="0.02" solmix="7"
    solref="0.3 0.4" solimp="0.1 0.2 0.3 0.4 5" group="4" euler="0 0 30"{moving}/>
</default>"""
"""Defaults by which blocks would not touch, would lean, rub and yield otherwise, and carry away what is on them."""


def _hostile(way: Callable[[Any, Path], Any]) -> str:
    """Defaults against a way to add blocks: a file has no `surfacevel`, which MuJoCo 3 does not read."""
    return HOSTILE.format(moving="" if "include" in way.__name__ else ' surfacevel="1 0 0 0 0 0"')


pytestmark = pytest.mark.filterwarnings("ignore:compiler attribute 'settotalmass'")  # of Gymnasium's own file


def _contacts(file: Path) -> tuple[int, float, set[int], set[float]]:
    """Put a robot above level blocks for two seconds: how often it touched them, and how high its lowest geom is then.

    Then the sizes of the contacts, and their coefficients of friction.
    """
    spec, grid = mujoco.MjSpec.from_file(str(file)), BlockGrid(RECIPE)
    grid.add_to(spec)
    model = spec.compile()
    grid.write(model, np.full(grid.shape, LEVEL))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    roots = roots_of(model)
    for root in roots:
        data.qpos[root.at] += TOP + 0.02 - geom_bounds(model, data, root.geoms)[0][:, 2].min()
    first = model.geom(grid.names[0]).id
    count = 0
    sizes: set[int] = set()
    frictions: set[float] = set()
    while data.time < 2:
        mujoco.mj_step(model, data)
        contact = data.contact
        own = ((contact.geom >= first) & (contact.geom < first + len(grid.names))).any(axis=1)
        count, sizes = count + int(own.sum()), sizes | set(np.unique(contact.dim[own]).tolist())
        frictions |= set(np.unique(np.round(contact.friction[own, :2], 9)).tolist())
    mujoco.mj_kinematics(model, data)
    lowest = min((geom_bounds(model, data, root.geoms)[0][:, 2].min() for root in roots), default=np.nan)
    return count, float(lowest), sizes, frictions


def _check(file: Path, *, stands: bool) -> None:
    count, lowest, sizes, frictions = _contacts(file)
    assert count > 20
    assert sizes == {3}
    assert frictions == {FRICTION}
    assert lowest == pytest.approx(TOP, abs=0.02) if stands else np.isnan(lowest)


@pytest.mark.slow
@pytest.mark.parametrize("file", GYMNASIUM, ids=lambda file: file.stem)
def test_robots_of_gymnasium_stand_and_rub_on_blocks(file: Path) -> None:
    assert len(GYMNASIUM) >= 14
    _check(file, stands=file.stem in STAND)


@pytest.mark.slow
@pytest.mark.parametrize("robot", MENAGERIE)
def test_robots_of_menagerie_stand_and_rub_on_blocks(robot: str) -> None:
    folder = os.environ.get("RSEGEN_MENAGERIE")
    if not folder:
        pytest.skip("RSEGEN_MENAGERIE names no folder with MuJoCo Menagerie, which is no package")
    file = Path(folder) / f"{robot}.xml"
    if not file.is_file():
        pytest.skip(f"{file} is not there")
    _check(file, stands=robot in STAND)


def _by_grid(spec: Any, _: Path) -> Any:
    BlockGrid(RECIPE).add_to(spec)
    return spec.compile()


def _by_map(spec: Any, _: Path) -> Any:
    add_map(spec, rsegen.compose(RECIPE))
    return spec.compile()


def _by_grid_in_a_file(spec: Any, _: Path) -> Any:
    BlockGrid(RECIPE).add_to(spec)
    spec.compile()
    return mujoco.MjModel.from_xml_string(spec.to_xml())


def _by_include(spec: Any, folder: Path) -> Any:
    """As users write it: the robot's own file, with the map's in it."""
    scene = rsegen.compose(RECIPE)
    for path, content in made(Mjcf(), scene).items():
        (folder / path).write_bytes(content)
    spec.compile()
    text = spec.to_xml().replace("<worldbody>", f'<include file="{scene.name}.xml"/><worldbody>', 1)
    (folder / "robot.xml").write_text(text, "utf-8")
    return mujoco.MjModel.from_xml_path(str(folder / "robot.xml"))


def _by_include_of_the_scene(spec: Any, folder: Path) -> Any:
    """The ground of the scene with the map."""
    scene = rsegen.compose(RECIPE)
    for path, content in made(Mjcf(shape="mesh"), scene).items():
        (folder / path).write_bytes(content)
    spec.compile()
    text = spec.to_xml().replace("<worldbody>", '<include file="scene.xml"/><worldbody>', 1)
    (folder / "robot.xml").write_text(text, "utf-8")
    return mujoco.MjModel.from_xml_path(str(folder / "robot.xml"))


WAYS = [_by_grid, _by_map, _by_grid_in_a_file, _by_include, _by_include_of_the_scene]
DECISIVE = ("contype", "conaffinity", "condim", "priority", "friction", "solmix", "solref", "solimp", "margin", "gap")


def _blocks(model: Any) -> Iterator[int]:
    """The geoms that are no robot's and can be touched."""
    for geom in range(model.ngeom):
        if model.geom_bodyid[geom] != model.body("robot").id and model.geom_contype[geom]:
            yield geom


@pytest.mark.parametrize("way", WAYS)
def test_no_default_of_a_robot_decides_a_contact_of_a_block(way: Callable[[Any, Path], Any], tmp_path: Path) -> None:
    robot = '<worldbody><body name="robot" pos="0 0 2"><freejoint/><geom size="0.1" contype="1"/></body></worldbody>'
    tables = []
    for defaults, folder in (("", tmp_path / "plain"), (_hostile(way), tmp_path / "hostile")):
        folder.mkdir()
        model = way(mujoco.MjSpec.from_string(f"<mujoco>{defaults}{robot}</mujoco>"), folder)
        blocks = list(_blocks(model))
        assert len(blocks) > 100
        names = [f"geom_{name}" for name in (*DECISIVE, "group", "pos", "quat", "size")]
        tables.append({name: getattr(model, name)[blocks] for name in names})
        if way in (_by_grid, _by_map, _by_grid_in_a_file):
            tables[-1]["surfacevel"] = model.geom_surfacevel[blocks]
    plain, hostile = tables
    for name in plain:
        assert np.array_equal(plain[name], hostile[name]), name
    assert (plain["geom_priority"] == 10).all()
    assert set(np.round(plain["geom_friction"][:, 0], 9)) <= {0.3, *FRICTIONS}


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("bits", [(1, 0), (0, 1), (2, 2), (4, 0), (2**20, 0)])
def test_whatever_can_touch_anything_rests_on_a_block(
    way: Callable[[Any, Path], Any], bits: tuple[int, int], tmp_path: Path
) -> None:
    contype, conaffinity = bits
    own = 'margin="0" gap="0" surfacevel="0 0 0 0 0 0"'
    ball = f'<geom size="0.05" contype="{contype}" conaffinity="{conaffinity}" {own}/>'
    robot = f'<worldbody><body name="robot" pos="0.1 0.1 0.5"><freejoint/>{ball}</body></worldbody>'
    model = way(mujoco.MjSpec.from_string(f"<mujoco>{_hostile(way)}{robot}</mujoco>"), tmp_path)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    ground = rsegen.Ground.of(rsegen.compose(RECIPE))
    levels = ground.field().levels
    if way in (_by_grid, _by_grid_in_a_file):
        levels = np.full_like(levels, 5)  # as compiled
    mujoco.mj_step(model, data, 500)
    assert data.qpos[2] == pytest.approx(levels[15, 15] * 0.05 + 0.05, abs=0.003)


ARM = """
<mujoco>
  <worldbody>
    <geom name="floor" type="plane" size="1 1 1" contype="0" conaffinity="0"/>
    <body name="leg" pos="0 0 1">
      <joint name="up" type="slide" axis="0 0 1"/>
      <geom name="shank" size="0.05" contype="0" conaffinity="0"/>
      <geom name="foot" size="0.05" pos="0 0 -0.1" contype="0" conaffinity="0"/>
    </body>
    <body name="goal" pos="0 0 1">
      <joint name="aside" type="slide"/>
      <geom name="mark" size="0.05" contype="0" conaffinity="0"/>
    </body>
  </worldbody>
  {more}
</mujoco>"""
PAIR = '<contact><pair geom1="foot" geom2="floor"/></contact>'
MOTOR = '<actuator><motor joint="{joint}"/></actuator>'


@pytest.mark.parametrize(
    ("more", "touching"),
    [
        ("", set()),
        (PAIR, {"foot"}),
        (MOTOR.format(joint="up"), {"shank", "foot"}),
        (MOTOR.format(joint="up") + PAIR, {"foot"}),
        (MOTOR.format(joint="aside"), {"mark"}),
    ],
    ids=["nothing is driven", "pair", "driven", "driven, pair", "the other"],
)
def test_what_touches_nothing_but_by_pairs_touches_blocks_alone(more: str, touching: set[str]) -> None:
    spec = mujoco.MjSpec.from_string(ARM.format(more=more))
    BlockGrid(RECIPE).add_to(spec)
    model = spec.compile()
    robots = ("shank", "foot", "mark")
    assert {name for name in robots if model.geom(name).conaffinity & model.geom("block_0_0").contype} == touching
    for one in (*robots, "floor"):
        assert not any(model.geom(one).contype & model.geom(other).conaffinity for other in (*robots, "floor"))


@pytest.mark.parametrize(("priority", "acts"), [(10, FRICTION), (0, 0.9), (-1, 0.9), (1, FRICTION)])
@pytest.mark.parametrize("own", [0.9, 0.1])
def test_the_ground_tells_the_friction_that_acts(priority: int, acts: float, own: float) -> None:
    """By what MuJoCo makes of the contact, for feet of priority 0."""
    grid, spec = BlockGrid(RECIPE, contact=Contact(priority=priority)), mujoco.MjSpec()
    grid.add_to(spec)
    body = spec.worldbody.add_body(pos=[0.1, 0.1, TOP + 0.049])
    body.add_freejoint()
    body.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.05, 0, 0], friction=[own, 0.005, 0.0001])
    model = spec.compile()
    levels = np.full(grid.shape, LEVEL)
    grid.write(model, levels)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert data.ncon == 1
    found = grid.ground(levels).acting_friction([[0.1, 0.1]], own)
    assert found == pytest.approx(data.contact.friction[0, 0])
    assert found == pytest.approx(acts if own == 0.9 else {0: FRICTION, -1: 0.1}.get(priority, FRICTION))


def test_feet_of_a_higher_priority_slide_by_the_blocks_friction_up_to_theirs() -> None:
    """A box on a slope of 0.45, on blocks of 0.55 and of 0.35: it stays, and slides, though its own friction is 2."""
    for level, slides in ((3, False), (1, True)):
        grid, spec = BlockGrid(RECIPE), mujoco.MjSpec()
        spec.option.gravity, spec.option.cone = [0.45 * 9.81, 0, -9.81], mujoco.mjtCone.mjCONE_ELLIPTIC
        grid.add_to(spec)
        body = spec.worldbody.add_body(pos=[-2, 0, level * 0.05 + 0.05])
        body.add_freejoint()
        shape = {"type": mujoco.mjtGeom.mjGEOM_BOX, "size": [0.15, 0.15, 0.05]}
        body.add_geom(**shape, friction=[2, 0.005, 0.0001], priority=1, condim=1)
        model = spec.compile()
        grid.write(model, np.full(grid.shape, level))
        data = mujoco.MjData(model)
        mujoco.mj_step(model, data, 500)
        assert (data.qpos[0] + 2 > 0.2) == slides, level
        assert abs(data.qpos[2] - level * 0.05 - 0.05) < 0.005


@pytest.mark.parametrize("condim", [1, 3])
def test_on_blocks_of_condim_1_no_friction_acts(condim: int) -> None:
    """A box of friction 0.9 on a slope of 0.1: it slides as fast as without any friction, or not at all."""
    grid, spec = BlockGrid(RECIPE, contact=Contact(condim=condim)), mujoco.MjSpec()
    spec.option.gravity, spec.option.cone = [0.1 * 9.81, 0, -9.81], mujoco.mjtCone.mjCONE_ELLIPTIC
    grid.add_to(spec)
    body = spec.worldbody.add_body(pos=[-1, 0, TOP + 0.05])
    body.add_freejoint()
    body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.15, 0.15, 0.05], friction=[0.9, 0.005, 0.0001])
    model, levels = spec.compile(), np.full(grid.shape, LEVEL)
    grid.write(model, levels)
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 300)
    assert data.ncon > 0
    free = 0.1 * 9.81 * data.time**2 / 2
    assert data.qpos[0] + 1 == pytest.approx(free if condim == 1 else 0, abs=0.02 * free)
    acting = grid.ground(levels).acting_friction([[0.0, 0.0]], 0.9)
    assert acting == pytest.approx(0 if condim == 1 else FRICTION)
    assert grid.ground(levels).acting_friction([[0.0, 0.0]], 0.9, priority=11) == pytest.approx(0.9)


def test_a_contact_of_no_sort_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"condim: 2 is not a condim of MuJoCo; use 1, 3, 4 or 6"):
        Contact(condim=2)
    with pytest.raises(ParameterError, match=r"priority: 1.5 is not a whole number"):
        Contact(priority=1.5)  # type: ignore[arg-type]
    assert replace(Contact(), condim=6).attributes(0.4)["friction"] == (0.4, 0.005, 0.0001)


def test_each_tile_of_a_terrain_has_the_friction_of_its_recipe() -> None:
    """By contacts on every tile and around them, and by the ground of the terrain."""
    ice, wood = (
        replace(RECIPE, name=name, chunk_size=8, block_width_cm=10, friction=friction, level_friction=of_levels)
        for name, friction, of_levels in (("ice", 0.1, None), ("wood", 0.6, (0.7, 0.8)))
    )
    terrain = rsegen.Terrain(recipes=[ice, wood], rows=3, columns=4, border=3, gap=1)
    spec = mujoco.MjSpec()
    add_terrain(spec, terrain, pos=(1, 2, 0.3))
    foot = spec.worldbody.add_body()
    foot.add_freejoint()
    foot.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.02, 0, 0], friction=[0.4, 0.02, 0.01], priority=1)
    model = spec.compile()
    data, ground = mujoco.MjData(model), terrain.ground((1, 2, 0.3))
    assert np.array_equal(ground.levels, terrain.field.levels)
    found = set()
    for i, j in np.random.default_rng(0).integers(0, terrain.field.shape, (300, 2)):
        x, y = ((at + 0.5 - cells / 2) * 0.1 for at, cells in zip((i, j), terrain.field.shape, strict=True))
        data.qpos[:3] = 1 + x, 2 + y, ground.heights([1 + x, 2 + y]) + 0.0195
        mujoco.mj_forward(model, data)
        assert data.ncon == 1
        level = terrain.field.levels[i, j]
        tile = (np.abs(terrain.origins[..., :2] - (x, y)) < 0.4).all(axis=2)
        kind = {0: "ice", 1: "ice", 2: "wood", 3: "wood"}[int(np.nonzero(tile)[1][0])] if tile.any() else "ice"
        expected = 0.1 if kind == "ice" else [0.6, 0.7, 0.8, 0.6, 0.6, 0.6][level]
        assert data.contact.friction[0, 0] == pytest.approx(expected)
        assert ground.friction([1 + x, 2 + y]) == pytest.approx(expected)
        found.add((kind, expected))
    assert len(found) == 4
    of_feet = terrain.ground((1, 2, 0.3), Contact(priority=-1))
    assert of_feet.acting_friction([1.0, 2.0], 0.4) == pytest.approx(0.4)
    assert ground.acting_friction([1.0, 2.0], 0.4) == ground.friction([1.0, 2.0])
    scene = rsegen.compose(ice)
    assert rsegen.Ground.of(scene, contact=Contact(priority=-1)).acting_friction([0.0, 0.0], 0.4) == pytest.approx(0.4)
    assert rsegen.Ground.of(scene).acting_friction([0.0, 0.0], 0.4) == pytest.approx(0.1)
    assert terrain.spots((0.3, 0.3)).shape == (3, 4, 1, 4)
    with pytest.raises(ParameterError, match=r"^recipes\[1\]\.friction: 0\.6"):
        assert terrain.recipe
