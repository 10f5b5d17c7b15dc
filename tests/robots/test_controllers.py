"""Which files of controllers are those of a robot, and what of them ROS reads."""

from __future__ import annotations

from pathlib import Path
from xml.etree.ElementTree import fromstring

import pytest

from rsegen.robots.drives import Wheels
from rsegen.robots.files.controllers import controls
from rsegen.robots.files.sdf_file import SdfRobot, from_file
from tests.robots.urdf_robots import two_wheels_urdf

PACKAGE = "<package><name>{}</name>{}</package>"
WHEELS = "drive:\n  left_wheel: {}left_hub\n  right_wheel: {}right_hub\n  linear: {{x: {{max_velocity: 1.7}}}}\n"
FOREIGN = WHEELS.format("", "") + "  wheel_separation: 0.12\n"


def workspace(folder: Path, own: str, other: str, content: str, needs: str = "") -> SdfRobot:
    """The two wheels of a package in a workspace whose other package has a file of a controller."""
    (folder / own / "urdf").mkdir(parents=True)
    (folder / other / "config").mkdir(parents=True)
    (folder / own / "package.xml").write_text(PACKAGE.format(own, needs))
    (folder / other / "package.xml").write_text(PACKAGE.format(other, ""))
    (folder / other / "config/control.yaml").write_text(content)
    file = folder / own / "urdf/robot.urdf"
    file.write_text(two_wheels_urdf(""))
    return from_file(file)


def separation(robot: SdfRobot) -> float:
    assert isinstance(robot.drive, Wheels)
    return robot.drive.separation


@pytest.mark.parametrize(
    ("own", "other"),
    [
        ("my_robot_description", "small_control"),
        ("my_robot_description", "tiny"),
        ("my_robot_description", "my_other_robot_control"),
        ("large", "tiny"),
    ],
)
def test_a_controller_of_another_robots_package_is_not_used_and_named(tmp_path: Path, own: str, other: str) -> None:
    robot = workspace(tmp_path, own, other, FOREIGN)
    assert separation(robot) == pytest.approx(0.3)
    assert "speed" in robot.assumed
    assert any(
        note.startswith(f"my_robot: {other}/config/control.yaml is not used: its wheels are called like those")
        for note in robot.notes("classic")
    )


@pytest.mark.parametrize(
    ("own", "other", "needs"),
    [
        ("my_robot_description", "my_robot_control", ""),
        ("my_robot_xl_description", "my_robot_bringup", ""),
        ("big_description", "small_control", "<exec_depend>small_control</exec_depend>"),
    ],
)
def test_a_controller_of_a_package_of_the_robot_counts(tmp_path: Path, own: str, other: str, needs: str) -> None:
    robot = workspace(tmp_path, own, other, FOREIGN, needs)
    assert separation(robot) == 0.12
    assert robot.speed == 1.7
    note = next(robot.notes("classic"))
    assert f"by {other}/config/control.yaml, 0.12 m apart" in note
    assert "although its wheels are 0.3 m apart" in note


def test_packages_of_one_clone_belong_together(tmp_path: Path) -> None:
    (tmp_path / ".git").mkdir()
    assert separation(workspace(tmp_path, "big_description", "small_control", FOREIGN)) == 0.12


@pytest.mark.parametrize(
    "content",
    [
        WHEELS.format("", "") + "ekf: {two_d_mode: true, frequency: 50, two_d_mode: true}\n",
        WHEELS.format("", "").replace("1.7", "0.3") + WHEELS.format("", ""),
        WHEELS.format("'$(arg prefix)", "'$(arg prefix)").replace("_hub", "_hub'"),
        WHEELS.format("$(var prefix)", "$(var prefix)"),
        WHEELS.format("${namespace}/", "${namespace}/"),
        WHEELS.format("<prefix>", "<prefix>"),
    ],
)
def test_a_file_that_ros_reads_is_read(tmp_path: Path, content: str) -> None:
    robot = workspace(tmp_path, "my_description", "my_control", content)
    assert robot.speed == 1.7
    assert separation(robot) == pytest.approx(0.3)


def test_a_prefix_is_what_the_joints_begin_with(tmp_path: Path) -> None:
    file = tmp_path / "robot.urdf"
    (tmp_path / "package.xml").write_text(PACKAGE.format("my_description", ""))
    (tmp_path / "control.yaml").write_text(WHEELS.format("$(arg prefix)", "$(arg prefix)"))
    file.write_text(two_wheels_urdf("").replace("left_hub", "front_left_hub").replace("right_hub", "front_right_hub"))
    robot = from_file(file)
    assert robot.speed == 1.7
    assert robot.drive.left == ("front_left_hub",)


def test_a_file_that_names_the_wheels_and_is_not_read_is_named_with_its_line(tmp_path: Path) -> None:
    robot = workspace(tmp_path, "my_description", "my_control", WHEELS.format("", "") + "  <<: *unknown\n")
    assert "speed" in robot.assumed
    assert any(
        remark.startswith("left out, as it is not read: my_control/config/control.yaml:5") for remark in robot.remarks
    )


def test_of_several_controllers_that_whose_sizes_are_those_of_the_wheels_counts(tmp_path: Path) -> None:
    sizes = {"a_wide": (0.5, 0.09), "b_near": (0.3, 0.0505), "c_small": (0.2, 0.02)}
    (tmp_path / "package.xml").write_text(PACKAGE.format("my_description", ""))
    for speed, (name, (apart, radius)) in enumerate(sizes.items(), 1):
        content = WHEELS.format("", "").replace("1.7", str(speed))
        (tmp_path / f"{name}.yaml").write_text(content + f"  wheel_separation: {apart}\n  wheel_radius: {radius}\n")
    file = tmp_path / "robot.urdf"
    file.write_text(two_wheels_urdf(""))
    assert from_file(file).speed == 2
    named = (
        f"<plugin filename='libgazebo_ros2_control.so'><parameters>{tmp_path / 'c_small.yaml'}</parameters></plugin>"
    )
    file.write_text(two_wheels_urdf(named))  # what the robot names counts in any case
    assert from_file(file).speed == 3


@pytest.mark.parametrize("kind", ["small_100", "small_150", "small"])
def test_of_several_controllers_for_the_same_wheels_that_which_is_called_like_the_robot_counts(
    tmp_path: Path, kind: str
) -> None:
    (tmp_path / "package.xml").write_text(PACKAGE.format("my_description", ""))
    for speed, other in ((1, "small_100"), (2, "small_150"), (3, "small"), (4, "aerial")):
        (tmp_path / f"config/{other}").mkdir(parents=True)
        (tmp_path / f"config/{other}/control.yaml").write_text(WHEELS.format("", "").replace("1.7", str(speed)))
    file = tmp_path / f"urdf/{kind}.urdf"
    file.parent.mkdir()
    file.write_text(two_wheels_urdf(""))
    assert from_file(file).speed == {"small_100": 1, "small_150": 2, "small": 3}[kind]


def of_a_family(folder: Path, robot: str, *named: str, others: str = "", **files: str) -> SdfRobot:
    """The robot in a package with files for others, whose wheels are called alike, and with files of its own.

    others: what the files for others say more; named: files that the robot names
    """
    package = folder / "workspace" / "my_description"
    package.mkdir(parents=True, exist_ok=True)
    (package / "package.xml").write_text(PACKAGE.format("my_description", ""))
    for name, radius in (("broad", 0.09), ("narrow", 0.02)):
        files[name] = WHEELS.format("", "") + (others or f"  wheel_separation: 0.12\n  wheel_radius: {radius}\n")
    for name, content in files.items():
        (package / f"{name}.yaml").write_text(content)
    named_files = "".join(f"<parameters>{package / name}.yaml</parameters>" for name in named)
    plugin = f"<gazebo><plugin filename='libgz_ros2_control-system.so'>{named_files}</plugin></gazebo>"
    file = package / "robot.urdf"
    file.write_text(robot.replace("</robot>", f"{plugin}</robot>"))
    return from_file(file)


def test_of_several_files_none_counts_if_all_are_of_other_wheels(tmp_path: Path) -> None:
    robot = of_a_family(tmp_path, two_wheels_urdf(""))
    assert separation(robot) == pytest.approx(0.3)
    assert "speed" in robot.assumed
    read = robot.read_drive
    assert read is not None
    assert read.origin == (
        "the shapes of its links, as its file does not say; not by workspace/my_description/broad.yaml,"
        " workspace/my_description/narrow.yaml, which have other wheels"
    )


REAR = """  <link name="rear_{side}_wheel">
    <inertial><mass value="0.2"/><inertia ixx="5e-4" ixy="0" ixz="0" iyy="5e-4" iyz="0" izz="8e-4"/></inertial>
    <collision><geometry><cylinder radius="0.05" length="0.02"/></geometry></collision></link>
  <joint name="rear_{side}_hub" type="continuous"><origin xyz="-0.2 {y} 0" rpy="-1.5707963267948966 0 0"/>
    <parent link="base"/><child link="rear_{side}_wheel"/><axis xyz="0 0 1"/></joint>
"""


@pytest.mark.parametrize("multiplier", ["wheel_radius_multiplier", "left_wheel_radius_multiplier"])
def test_of_several_files_the_one_whose_radius_fits_with_its_multiplier_counts(tmp_path: Path, multiplier: str) -> None:
    other = WHEELS.format("", "") + "  wheel_radius: 0.02\n"
    assert "speed" in of_a_family(tmp_path, two_wheels_urdf(""), own=other).assumed
    assert of_a_family(tmp_path, two_wheels_urdf(""), own=f"{other}  {multiplier}: 2.5\n").speed == 1.7


def test_of_several_files_the_one_that_is_called_like_the_robot_counts(tmp_path: Path) -> None:
    fits = WHEELS.format("", "") + "  wheel_radius: 0.05\n"
    for name, speed in (("alpha", 1.7), ("beta", 0.7)):
        text = two_wheels_urdf("").replace('"my-robot"', f'"{name}"')
        assert of_a_family(tmp_path, text, alpha=fits, beta=fits.replace("1.7", "0.7")).speed == speed


def test_of_several_files_those_that_leave_out_driven_wheels_do_not_count(tmp_path: Path) -> None:
    joints = "".join(
        f'<joint name="{end}{side}_hub"><command_interface name="velocity"/></joint>'
        for end in ("", "rear_")
        for side in ("left", "right")
    )
    rear = "".join(REAR.format(side=side, y=y) for side, y in (("left", 0.15), ("right", -0.15)))
    text = two_wheels_urdf("").replace("</robot>", f"{rear}<ros2_control name='all'>{joints}</ros2_control></robot>")
    robot = of_a_family(tmp_path, text, others="  wheel_radius: 0.05\n")
    assert robot.drive.left == ("left_hub", "rear_left_hub")
    assert "speed" in robot.assumed


def test_a_file_that_the_robot_names_and_that_drives_otherwise_keeps_those_of_others_out(tmp_path: Path) -> None:
    near = WHEELS.format("", "") + "  wheel_radius: 0.05\n"
    own = "manager: {drive: {type: tricycle_controller/TricycleController}}\n"
    states = "manager: {states: {type: joint_state_broadcaster/JointStateBroadcaster}}\n"
    assert of_a_family(tmp_path, two_wheels_urdf(""), "states", states=states, near=near).speed == 1.7
    assert "speed" in of_a_family(tmp_path, two_wheels_urdf(""), "own", own=own, near=near).assumed


def test_files_that_a_robot_names_count_beside_one_of_its_arm(tmp_path: Path) -> None:
    arm = "manager: {arm: {type: joint_trajectory_controller/JointTrajectoryController}}\n"
    wheels = WHEELS.format("", "") + "  wheel_radius: 0.05\n"
    robot = of_a_family(tmp_path, two_wheels_urdf(""), "arm", "wheels", arm=arm, wheels=wheels)
    assert robot.speed == 1.7
    assert "speed" not in robot.assumed


def test_joints_take_what_one_of_their_interfaces_says(tmp_path: Path) -> None:
    both = '<joint name="{}">{}</joint>'
    kinds = {"wheel": ("Effort", "Velocity"), "rod": ("Position",), "spring": (), "motor": ("Effort",)}
    interfaces = "<hardwareInterface>hardware_interface/{}JointInterface</hardwareInterface>"
    joints = "".join(both.format(name, "".join(map(interfaces.format, own))) for name, own in kinds.items())
    joints += "<joint name='blank'><hardwareInterface/></joint>"
    older = controls(fromstring(f"<robot><transmission>{joints}</transmission></robot>"), tmp_path / "a.urdf")
    assert (older.rates, older.placed, older.rated_by) == ({"wheel": None}, frozenset({"rod"}), "its <transmission>")
    velocity = '<command_interface name="velocity"><param name="min">-3</param><param name="max">3</param>'
    joint = f'<joint name="wheel">{velocity}</command_interface><command_interface name="effort"/></joint>'
    newer = controls(fromstring(f"<robot><ros2_control>{joint}</ros2_control></robot>"), tmp_path / "a.urdf")
    assert (newer.rates, newer.placed, newer.rated_by) == ({"wheel": 3.0}, frozenset(), "ros2_control")
