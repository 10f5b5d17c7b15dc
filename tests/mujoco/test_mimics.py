"""Joints that follow others do so in MuJoCo, by multiplier and offset; what follows what is held is held."""

from __future__ import annotations

from math import radians
from pathlib import Path

import pytest

from rsegen.errors import FileError
from rsegen.mujoco.world import MujocoWorld
from rsegen.robots.files.sdf_file import SdfRobot, from_file
from rsegen.simulators.poses import DROP_HEIGHT, Pose
from tests.mujoco.test_robots_of_files import cart, inertial, wheel
from tests.mujoco.worlds import step_of, world_of
from tests.robots.mjcf_robots import two_wheels_mjcf
from tests.robots.urdf_robots import two_wheels_urdf

FRONT = "left_axle,right_axle"


def angle(world: MujocoWorld, joint: str) -> float:
    return float(world.data.joint(f"robot/{joint}").qpos[0])


def mimic(leader: str, multiplier: float = 1.0, offset: float = 0.0, more: str = "") -> str:
    values = f"<multiplier>{multiplier}</multiplier><offset>{offset}</offset>{more}"
    return f'<mimic joint="{leader}">{values}</mimic>'


def four_wheels(folder: Path, axis: int, rear_axis: int, *, led: bool = True, front_mu: float = 1.0) -> SdfRobot:
    """Return a robot whose front wheels have motors, and whose rear ones follow these forward, or roll."""
    ratio = axis * rear_axis
    axles = [mimic(f"{side}_axle", ratio) if led else "" for side in ("left", "right")]
    wheels = [wheel(side, 0.1, y, axis=axis, mu=front_mu) for side, y in (("left", 0.1), ("right", -0.1))]
    rear = [(f"rear_{side}", y) for side, y in (("left", 0.1), ("right", -0.1))]
    wheels += [wheel(name, -0.1, y, axis=rear_axis, axle=a) for (name, y), a in zip(rear, axles, strict=True)]
    cart(folder, wheels, caster=None)
    return from_file(folder / "cart.sdf", FRONT)


@pytest.mark.parametrize("axis", [1, -1])
@pytest.mark.parametrize("rear_axis", [1, -1])
def test_rear_wheels_that_follow_drive_too(tmp_path: Path, axis: int, rear_axis: int) -> None:
    """The front ones have next to no friction, so a robot whose rear wheels roll stays."""
    ways = []
    for led in (True, False):
        robot = four_wheels(tmp_path, axis, rear_axis, led=led, front_mu=0.01)
        assert robot.drive.left == ("left_axle",)
        assert robot.followers == (("rear_left_axle", "rear_right_axle") if led else ())
        world = world_of(robot)
        world.step(500)
        before = world.poses()["robot"].x
        world.drive("robot", robot, 0.2, 0.0)
        world.step(2000)
        ways.append(world.poses()["robot"].x - before)
        if led:
            turned = angle(world, "left_axle")
            assert abs(turned) > 7
            assert angle(world, "rear_left_axle") == pytest.approx(rear_axis * turned, abs=0.01)  # of the left
    assert ways[0] == pytest.approx(0.4, abs=0.01)
    assert ways[1] < 0.2


ROCKERS = """
  <link name="{0}"><pose>0 {1} 0.1 0 0 0</pose>{2}</link>
  <joint name="{0}_rocker" type="revolute"><parent>base</parent><child>{0}</child>
    <axis><xyz>0 1 0</xyz><limit><lower>-0.6</lower><upper>0.6</upper></limit>{3}</axis></joint>"""


def rover(folder: Path, follows: str) -> SdfRobot:
    """Return a robot with four wheels on two rockers, of which the right one may follow the left one."""
    parts = [ROCKERS.format(side, y, inertial(0.3, 2e-3), more) for side, y, more in (
        ("left", 0.15, ""), ("right", -0.15, follows)
    )]  # fmt: skip
    places = [(f"{end}_{side}", x, y, side) for side, y in (("left", 0.2), ("right", -0.2)) for end, x in (
        ("front", 0.15), ("rear", -0.15)
    )]  # fmt: skip
    wheels = [
        wheel(name, x, y, width=0.03).replace("<parent>base</parent>", f"<parent>{side}</parent>")
        for name, x, y, side in places
    ]
    return cart(folder, [*parts, *wheels], caster=None)


@pytest.mark.parametrize(("multiplier", "offset"), [(-1.0, 0.0), (-0.5, 0.0), (-1.0, 0.1)])
def test_rockers_that_follow_each_other_are_a_differential(tmp_path: Path, multiplier: float, offset: float) -> None:
    robot = rover(tmp_path, mimic("left_rocker", multiplier, offset))
    assert robot.held == ()
    assert robot.followers == ("right_rocker",)
    world = world_of(robot, step_of(0.04), Pose(x=-1.4, y=-1.1, z=DROP_HEIGHT))  # its left side beside the platform
    world.drive("robot", robot, 0.2, 0.0)
    angles = []
    for _ in range(40):
        world.step(100)
        left, right = angle(world, "left_rocker"), angle(world, "right_rocker")
        assert right == pytest.approx(multiplier * left + offset, abs=0.01)
        angles.append(left)
    assert max(angles) - min(angles) > radians(1)


def test_a_rocker_without_a_partner_is_held(tmp_path: Path) -> None:
    assert rover(tmp_path, "").held == ("left_rocker", "right_rocker")


def test_wheels_that_are_steered_together_are_held(tmp_path: Path) -> None:
    robot = rover(tmp_path, mimic("left_rocker"))
    file = tmp_path / "cart.sdf"
    file.write_text(file.read_text().replace("<xyz>0 1 0</xyz>", "<xyz>0 0 1</xyz>"))
    assert robot.held == ()
    names = [f"{end}_{side}_axle" for side in ("left", "right") for end in ("front", "rear")]
    steered = from_file(file, ",".join("+".join(names[at : at + 2]) for at in (0, 2)))
    assert steered.held == ("left_rocker", "right_rocker")


FINGERS = """
  <link name="{0}"><inertial><mass value="0.1"/>
    <inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="{0}_joint" type="prismatic"><origin xyz="0 0 0.1"/><parent link="base"/><child link="{0}"/>
    <axis xyz="0 1 0"/><limit lower="0" upper="0.1" effort="1" velocity="1"/>{1}</joint>"""


def test_what_follows_what_is_held_is_held(tmp_path: Path) -> None:
    fingers = FINGERS.format("thumb", "") + FINGERS.format("index", '<mimic joint="thumb_joint"/>')
    file = tmp_path / "hand.urdf"
    file.write_text(two_wheels_urdf().replace("</robot>", f"{fingers}</robot>"))
    robot = from_file(file)
    assert robot.held == ("index_joint", "thumb_joint")
    assert robot.followers == ()
    assert robot.drive.left == ("left_hub",)


@pytest.mark.parametrize(
    ("leader", "values", "says"),
    [
        ("left_axle", "<multiplier>much</multiplier>", "'much' is not a number"),
        ("left_axle", "<offset>nan</offset>", "'nan' is not a number"),
    ],
)
def test_what_is_no_number_is_one_line(tmp_path: Path, leader: str, values: str, says: str) -> None:
    rear = wheel("rear", -0.1, 0.0, axle=f'<mimic joint="{leader}">{values}</mimic>')
    with pytest.raises(FileError, match=rf"cart\.sdf: <mimic> of joint rear_axle: {says}"):
        cart(tmp_path, [wheel("left", 0, 0.1), wheel("right", 0, -0.1), rear])


@pytest.mark.parametrize("leader", ["nobody", "rear_axle", "base"])
def test_what_follows_nothing_moves_on_its_own(tmp_path: Path, leader: str) -> None:
    robot = cart(tmp_path, [wheel("left", 0, 0.1), wheel("right", 0, -0.1), wheel("rear", -0.1, 0, axle=mimic(leader))])
    assert robot.followers == ()
    assert world_of(robot).model.neq == 0


def test_joints_of_mjcf_follow_by_its_equalities(tmp_path: Path) -> None:
    more = """<body name="disc" pos="0 0 0.2"><joint name="spin" axis="0 0 1"/>
      <geom type="cylinder" size="0.05 0.01" mass="0.1"/></body>
      <body name="bent" pos="0 0 0.3"><joint name="bend" axis="0 0 1"/>
      <geom type="cylinder" size="0.05 0.01" mass="0.1"/></body>"""
    ties = """<equality><joint joint1="spin" joint2="left_hub" polycoef="0 2 0 0 0"/>
      <joint joint1="bend" joint2="left_hub" polycoef="0 1 1 0 0"/></equality>"""
    robot = from_file(two_wheels_mjcf(tmp_path, more=more, after=ties))
    assert robot.followers == ("spin",)
    assert any("more than a multiplier and an offset do not: bend" in remark for remark in robot.remarks)
    world = world_of(robot)
    world.drive("robot", robot, 0.2, 0.0)
    world.step(1500)
    assert abs(angle(world, "left_hub")) > 4
    assert angle(world, "spin") == pytest.approx(2 * angle(world, "left_hub"), rel=0.01)
