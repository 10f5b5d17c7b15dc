"""Steered wheels are refused, swivelling ones are casters, hinged ones drive; wheels without friction are named."""

from __future__ import annotations

import math
import re
from pathlib import Path

import pytest

from rsegen.errors import FileError
from rsegen.robots.drives import Wheels
from rsegen.robots.files.sdf_file import SdfRobot, from_file
from tests.robots.two_wheels import two_wheels
from tests.robots.urdf_robots import Limb, tree, two_wheels_urdf

PART = '<mass value="0.2"/><inertia ixx="5e-4" ixy="0" ixz="0" iyy="5e-4" iyz="0" izz="8e-4"/>'
HUNG = """\
  <link name="{side}_fork"><inertial>{part}</inertial></link>
  <joint name="{side}_pin" type="{kind}"><origin xyz="0.3 {y} 0.02" rpy="{tilt} 0 0"/>
    <parent link="base_footprint"/><child link="{side}_fork"/><axis xyz="{axis}"/>{limits}</joint>
  <link name="{side}_front"><inertial>{part}</inertial>
    <collision><geometry><cylinder radius="0.05" length="0.02"/></geometry></collision></link>
  <joint name="{side}_front_hub" type="continuous"><origin xyz="{trail} 0 0" rpy="{back} 0 0"/>
    <parent link="{side}_fork"/><child link="{side}_front"/><axis xyz="0 0 1"/></joint>
"""
LIMITS = '<limit lower="-0.5" upper="0.5" effort="1" velocity="1"/>'
CONTROL = '<ros2_control name="all">{}</ros2_control>'
POSED = '<joint name="{}_pin"><command_interface name="position"/></joint>'
RATED = '<joint name="{}_hub"><command_interface name="velocity"/></joint>'
TURNED = "<joint name='{}_pin'><hardwareInterface>hardware_interface/PositionJointInterface</hardwareInterface></joint>"


def hung(
    folder: Path, kind: str, axis: str, limits: str = "", more: str = "", lean: tuple[float, float] = (0.0, 0.0)
) -> SdfRobot:
    """Two wheels, and two more in front of them, each on a pin; lean: its tilt, radians, and the trail, metres."""
    tilt, trail = lean
    values = {
        "trail": trail,
        "kind": kind,
        "axis": axis,
        "limits": limits,
        "part": PART,
        "tilt": tilt,
        "back": -1.5707963267948966 - tilt,
    }
    front = "".join(HUNG.format(side=side, y=y, **values) for side, y in (("left", 0.15), ("right", -0.15)))
    file = folder / "cart.urdf"
    file.write_text(two_wheels_urdf("").replace("</robot>", f"{front}{more}</robot>"))
    return from_file(file)


def both(text: str) -> str:
    return "".join(text.format(side) for side in ("left", "right"))


@pytest.mark.parametrize(
    ("kind", "limits", "more", "tilt"),
    [
        ("revolute", LIMITS, "", 0.0),
        ("revolute", LIMITS, "", 0.3),  # a kingpin leans
        ("continuous", "", "", 0.0),  # a plug-in of its maker holds it: without a trail it is no caster
        ("continuous", "", CONTROL.format(both(POSED)), 0.0),
        ("continuous", "", CONTROL.format(both(POSED) + both(RATED)), 0.0),
        ("continuous", "", f"<transmission>{both(TURNED)}</transmission>", 0.0),
    ],
)
def test_wheels_on_an_upright_pin_that_is_held_are_steered(
    tmp_path: Path, kind: str, limits: str, more: str, tilt: float
) -> None:
    robot = hung(tmp_path, kind, "0 0 1", limits, more, (tilt, 0.0))
    assert robot.read_drive is None
    assert robot.steered == ("left_front_hub", "right_front_hub")
    assert from_file(tmp_path / "cart.urdf", "left_hub,right_hub").held == ("left_pin", "right_pin")


def test_wheels_on_an_upright_pin_that_nothing_holds_are_casters(tmp_path: Path) -> None:
    robot = hung(tmp_path, "continuous", "0 0 1", lean=(0.0, -0.02))
    assert not robot.steered
    assert isinstance(robot.drive, Wheels)
    assert robot.drive.left == ("left_hub",)


def test_wheels_on_universal_joints_are_steered(tmp_path: Path) -> None:
    file = tmp_path / "cart.sdf"
    text = two_wheels()
    for side in ("left", "right"):
        link = re.search(f'<link name="{side}_wheel">.*?</joint>', text, re.DOTALL)
        assert link
        front = (
            link[0].replace(side, f"front_{side}").replace("<pose>0 ", "<pose>0.3 ").replace("revolute", "universal")
        )
        pin = "<axis><xyz>0 -1 0</xyz><limit><lower>-0.5</lower><upper>0.5</upper></limit></axis><axis2>"
        text = text.replace(
            "</model>", front.replace("<axis>", pin).replace("1</xyz></axis>", "1</xyz></axis2>") + "</model>"
        )
    file.write_text(text)
    robot = from_file(file)
    assert robot.read_drive is None
    assert sorted(robot.steered) == ["front_left_hub", "front_right_hub"]


@pytest.mark.parametrize("axis", ["1 0 0", "0 1 0"])
@pytest.mark.parametrize("more", ["", CONTROL.format(both(RATED) + both(RATED.replace("_hub", "_front_hub")))])
def test_wheels_on_a_rocker_drive(tmp_path: Path, axis: str, more: str) -> None:
    robot = hung(tmp_path, "revolute", axis, LIMITS, more)
    assert not robot.steered
    assert isinstance(robot.drive, Wheels)
    assert robot.drive.left == ("left_front_hub", "left_hub")


@pytest.mark.parametrize(("mu", "is_named"), [("0", True), ("0.0", True), ("0.001", True), ("0.2", False)])
def test_wheels_without_friction_are_named(tmp_path: Path, mu: str, is_named: bool) -> None:
    file = tmp_path / "cart.sdf"
    file.write_text(two_wheels().replace("<mu>1</mu>", f"<mu>{mu}</mu>"))
    notes = [note for note in from_file(file).notes("mujoco") if "so it stands still" in note]
    assert len(notes) == is_named
    for note in notes:
        assert note.startswith(f"my_robot: the friction of what it drives on is {float(mu):g}")


def test_one_wheel_with_friction_pushes(tmp_path: Path) -> None:
    file = tmp_path / "cart.sdf"
    file.write_text(two_wheels().replace("<mu>1</mu>", "<mu>0</mu>", 1))
    assert not from_file(file).remarks


@pytest.mark.parametrize("steered", [True, False])
def test_a_car_whose_front_wheels_only_steer_is_refused(tmp_path: Path, steered: bool) -> None:
    wheel = """<link name="{side}_front"><inertial>{part}</inertial><collision><origin rpy="1.5707963267948966 0 0"/>
      <geometry><cylinder radius="0.05" length="0.02"/></geometry></collision></link>
      <joint name="{side}_pin" type="{kind}"><origin xyz="0.3 {y} 0.02"/><parent link="base_footprint"/>
      <child link="{side}_front"/><axis xyz="0 0 1"/>{limits}</joint>"""
    kind, limits = ("revolute", LIMITS) if steered else ("continuous", "")
    front = "".join(
        wheel.format(side=side, y=y, kind=kind, limits=limits, part=PART)
        for side, y in (("left", 0.15), ("right", -0.15))
    )
    file = tmp_path / "car.urdf"
    file.write_text(two_wheels_urdf("").replace("</robot>", f"{front}</robot>"))
    robot = from_file(file)
    assert robot.steered == (("left_pin", "right_pin") if steered else ())
    assert (robot.read_drive is None) is steered


KOBUKI = """<plugin name="drive" filename="libgazebo_ros_kobuki.so">
  <left_wheel_joint_name>left_hub</left_wheel_joint_name><right_wheel_joint_name>right_hub</right_wheel_joint_name>
  <wheel_separation>0.31</wheel_separation>{}<torque>1.5</torque></plugin>"""


@pytest.mark.parametrize(
    ("said", "radius_by"),
    [
        ("<wheel_diameter>0.1</wheel_diameter>", "its plug-in"),
        ("", "its wheels"),
    ],
)
def test_the_plug_in_of_a_turtlebot_2_is_read(tmp_path: Path, said: str, radius_by: str) -> None:
    file = tmp_path / "cart.sdf"
    file.write_text(two_wheels(KOBUKI.format(said)))
    read = from_file(file).read_drive
    assert read is not None
    assert (read.plugin, read.separation_by, read.radius_by) == ("gazebo_ros_kobuki", "its plug-in", radius_by)
    assert isinstance(read.drive, Wheels)
    assert (read.drive.separation, read.drive.radius, read.drive.torque) == (0.31, 0.05, 1.5)


def test_the_origin_of_each_size_of_a_controller_is_said(tmp_path: Path) -> None:
    (tmp_path / "package.xml").write_text("<package><name>cart_description</name></package>")
    names = "drive:\n  left_wheel: left_hub\n  right_wheel: right_hub\n"
    file = f"{tmp_path.name}/control.yaml"
    for more, origins in (
        ("  wheel_separation: 0.31\n", (file, "its wheels")),
        ("  wheel_radius: 0.05\n", ("its wheels", file)),
        ("  wheel_radius: 0.05\n  wheel_separation: 0.31\n", (file, file)),
        ("", ("its wheels", "its wheels")),
    ):
        (tmp_path / "control.yaml").write_text(names + more)
        (tmp_path / "cart.urdf").write_text(two_wheels_urdf(""))
        read = from_file(tmp_path / "cart.urdf").read_drive
        assert read is not None
        assert read.separation_by.endswith(origins[0])
        assert read.radius_by.endswith(origins[1])


def test_links_of_which_none_has_a_mass_are_named(tmp_path: Path) -> None:
    file = tmp_path / "arm.urdf"
    links = '<link name="world"/><link name="base"/><link name="upper"/>'
    joints = '<joint name="a" type="fixed"><parent link="world"/><child link="base"/></joint>'
    joints += '<joint name="b" type="continuous"><parent link="base"/><child link="upper"/></joint>'
    file.write_text(f'<robot name="arm">{links}{joints}</robot>')
    with pytest.raises(FileError, match=r"arm\.urdf: links 'world', 'base', 'upper' have no mass; a simulator needs"):
        from_file(file)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("<pose>-0.05 0 0.04 0 0 0</pose>", "<pose>-0.05 0 0.04 0 0</pose>", "the <pose> of collision 'hull'"),
        ("<pose>0 0 0.02 0 0 0</pose>", "<pose>0 0 O 0 0 0</pose>", "the <pose> of link 'base'"),
        ("<mass>3</mass>", "<pose>1 2</pose><mass>3</mass>", "the <pose> of inertial"),
    ],
)
def test_a_pose_that_is_none_is_named_with_its_element(tmp_path: Path, old: str, new: str, says: str) -> None:
    file = tmp_path / "cart.sdf"
    file.write_text(two_wheels().replace(old, new, 1))
    with pytest.raises(FileError) as caught:
        from_file(file)
    assert f"cart.sdf: {says}: " in str(caught.value)
    assert "is not 6 numbers" in str(caught.value)


def test_the_motors_of_an_arm_are_no_wheels(tmp_path: Path) -> None:
    """Two joints across, one on the other, one to the left of the other, as a pendulum with two motors has them."""
    base, across, middle, stick = (0.0,) * 6, (0, 0, math.pi / 2), (0, 0, 0.45, 0, 0, 0), (0.1, 0.1, 1)
    limbs = [
        Limb(0, "", base, across, 1, middle, stick),
        Limb(0, "continuous", (0, 0.1, 0.9, 0, 0, 0), across, 1, middle, stick),
        Limb(1, "continuous", (0, 0.1, 0.9, 0, 0, 0), across, 1, middle, stick),
    ]
    motors = "".join(f'<joint name="j{joint}"><command_interface name="velocity"/></joint>' for joint in (1, 2))
    file = tmp_path / "arm.urdf"
    file.write_text(tree(limbs, CONTROL.format(motors)))
    assert from_file(file).read_drive is None
