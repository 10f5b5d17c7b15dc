"""A robot as makers ship it, with packages, Xacro, ros2_control and a controller, is read by the name of its file."""

from __future__ import annotations

import re
import shutil
from importlib.util import find_spec
from pathlib import Path
from xml.etree import ElementTree

import pytest

import rsegen
from rsegen.errors import FileError
from rsegen.robots.drives import Wheels
from rsegen.robots.files.controllers import Controls, controls
from rsegen.robots.files.sdf_file import SdfRobot, from_file, is_robot_file
from rsegen.robots.files.uris import found_package, installed, packages_around
from rsegen.robots.files.xacro_files import with_arguments
from rsegen.robots.lookup import robot_of
from tests.robots.makers_robot import CONTROLLER, PACKAGE, makers_robot
from tests.robots.two_wheels import ROS_1, two_wheels

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(find_spec("xacro") is None, reason="the package xacro is not installed"),
]


def test_one_path_is_enough_and_all_that_is_assumed_is_said(tmp_path: Path) -> None:
    robot = from_file(makers_robot(tmp_path))
    plain = from_file(written(tmp_path / "mine.sdf", two_wheels()))
    drive = robot.drive
    assert isinstance(drive, Wheels)
    assert (drive.left, drive.right, drive.separation, drive.radius) == (("left_hub",), ("right_hub",), 0.3, 0.05)
    assert (robot.speed, robot.turn) == (0.35, 1.25)
    assert (*robot.size, robot.lift) == pytest.approx((*plain.size, plain.lift))
    says, missing, plugins = robot.notes("classic")
    assert says == (
        "rover: its wheels are left_hub,right_hub by rover_control/config/rover.yaml, 0.3 m apart, radius 0.05 m"
        " by rover_control/config/rover.yaml;"
        " size 0.400 x 0.320 x 0.130 m around its origin by its model; speed 0.35 m/s, turn rate 1.25 rad/s by"
        " rover_control/config/rover.yaml"
    )
    assert missing == "rover: left out what it includes of packages that are not found: somebodys_lasers"
    assert plugins.endswith("not here: libgazebo_ros2_control.so")
    # The wheels mirror each other; the plug-ins of drives take it that axes point to the left.
    assert axes(robot.text) == ["0 0 1", "0 0 1"]
    assert axes(robot.model("one")) == ["0 0 1", "0 0 -1"]


def test_every_command_reads_the_same_robot(tmp_path: Path) -> None:
    file = makers_robot(tmp_path)
    robot = robot_of(str(file))
    assert robot == from_file(file) == robot_of(file)
    field = rsegen.build(rsegen.Recipe(boundary="none", seed=1))
    assert rsegen.poses(field, file, 0, 0, 0).z == rsegen.poses(field, robot, 0, 0, 0).z


@pytest.mark.parametrize(
    ("controller", "wheels", "speed"),
    [
        (CONTROLLER.replace("linear.x.max_velocity: 0.35", "linear: {x: {max_velocity: 0.3}}"), "rover.yaml", 0.3),
        (CONTROLLER.replace("has_velocity_limits: true", "has_velocity_limits: false"), "rover.yaml", 8 * 0.05),
        ("my: {left_wheel: left_hub, right_wheel: right_hub}", "rover.yaml", 8 * 0.05),
        (CONTROLLER.replace("[left_hub]", "[left_hub, right_hub]"), "ros2_control", 8 * 0.05),
        (CONTROLLER.replace("[left_hub]", "[of_another]"), "ros2_control", 8 * 0.05),
        ("left_wheel_names: [right_wheel_names: {", "ros2_control", 8 * 0.05),
        ("&a [left_wheel_names, right_wheel_names, *a]", "ros2_control", 8 * 0.05),
        (None, "ros2_control", 8 * 0.05),
    ],
)
def test_speeds_are_those_of_the_controller_else_of_the_joints(
    tmp_path: Path, controller: str | None, wheels: str, speed: float
) -> None:
    robot = from_file(makers_robot(tmp_path, controller))
    assert robot.read_drive is not None
    assert robot.read_drive.origin.endswith(wheels)
    assert robot.speed == pytest.approx(speed)
    assert robot.drive.separation == pytest.approx(0.3)


def test_a_turn_rate_without_a_speed_is_that_of_the_controller(tmp_path: Path) -> None:
    controller = CONTROLLER.replace("    linear.x.max_velocity: 0.35\n", "")
    note = next(from_file(makers_robot(tmp_path, controller)).notes("classic"))
    assert note.endswith("speed 0.4 m/s, turn rate 1.25 rad/s by ros2_control and rover_control/config/rover.yaml")


def test_wheels_that_skid_turn_faster_as_their_controller_makes_them(tmp_path: Path) -> None:
    robot = from_file(makers_robot(tmp_path, CONTROLLER + "    wheel_separation_multiplier: 1.5\n"))
    assert robot.drive.separation == 0.3
    assert "0.3 m apart, times 1.5 as they skid, radius" in next(robot.notes("classic"))
    plugin = ElementTree.fromstring(robot.model("one", "sim")).find("plugin[@name='gz::sim::systems::DiffDrive']")
    assert plugin is not None
    assert float(plugin.findtext("wheel_separation", "")) == pytest.approx(0.45)


def test_arguments_stand_after_the_file(tmp_path: Path) -> None:
    file = makers_robot(tmp_path)
    heavy = robot_of(f"{file} mass:=7.5")
    assert isinstance(heavy, SdfRobot)
    assert heavy.body.mass - from_file(file).body.mass == pytest.approx(4.5)
    assert with_arguments("my robot.urdf.xacro a:=b  c:= ") == ("my robot.urdf.xacro", {"a": "b", "c": ""})
    assert is_robot_file("my robot.urdf.xacro a:=b")
    assert not is_robot_file("burger a:=b")
    sdf = written(tmp_path / "mine.sdf", two_wheels())
    with pytest.raises(FileError, match=r"mine\.sdf: a:= is for a Xacro file, and this one has no macros"):
        robot_of(f"{sdf} a:=b")


def test_what_is_needed_and_not_found_is_said_in_one_line(tmp_path: Path) -> None:
    file = makers_robot(tmp_path)
    for arguments, words in (
        ("laser:=true", ["unknown macro name: xacro:laser", "somebodys_lasers", "ROS_PACKAGE_PATH"]),
        ("laser:=maybe", ["xacro cannot expand it"]),
    ):
        with pytest.raises(FileError) as caught:
            robot_of(f"{file} {arguments}")
        assert all(word in str(caught.value) for word in words)
        assert "\n" not in str(caught.value)
    text = file.read_text()
    file.write_text(text.replace('<xacro:arg name="mass" default="3"/>', ""))
    with pytest.raises(FileError, match="argument mass; pass it after the file, as in 'FILE mass:=VALUE'"):
        from_file(file)
    assert robot_of(f"{file} mass:=3").size == pytest.approx((0.4, 0.32, 0.13))
    file.write_text(text)
    shutil.rmtree(file.parents[1] / "meshes")
    with pytest.raises(FileError, match=r"package://rover_description/meshes/caster\.obj of a collision shape is not"):
        from_file(file)


def test_packages_are_found_by_their_names_in_the_workspace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = makers_robot(tmp_path / "ws")
    far, deeper = tmp_path / "ws/src/lasers-2.0/laser_description", tmp_path / "elsewhere/share"
    for folder, name in ((far, "somebodys_lasers"), (deeper / "installed", "installed")):
        folder.mkdir(parents=True)
        (folder / "package.xml").write_text(PACKAGE.format(name))
    assert found_package("rover_description", file) == file.parents[1]
    assert found_package("somebodys_lasers", file) == far
    assert found_package("installed", file) is None
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path / "elsewhere"))
    assert found_package("installed", file) == deeper / "installed"
    assert next(packages_around(file)) == file.parents[1]
    assert not list(packages_around(tmp_path / "alone.urdf"))


def test_a_file_at_its_path_comes_before_one_that_an_installation_would_put_there(tmp_path: Path) -> None:
    paths = [tmp_path / folder / "meshes/hull.stl" for folder in ("", "older")]
    for path in paths:
        path.parent.mkdir(parents=True)
        path.touch()
    (tmp_path / "package.xml").write_text(PACKAGE.format("rover_description"))
    assert installed(paths[0]) == paths[0]
    paths[0].unlink()
    assert installed(paths[0]) == paths[1]


def test_a_folder_of_any_size_and_files_of_any_kind_are_passed_by(tmp_path: Path) -> None:
    file = makers_robot(tmp_path, None)
    config = file.parents[2] / "rover_control/config"
    (config / "huge.yaml").write_bytes(b"left_wheel right_wheel" * 2**16)
    (config / "binary.yaml").write_bytes(b"\xff\xfeleft_wheel right_wheel")
    (config / "folder.yaml").mkdir()
    (config / "loop").symlink_to(config)
    for number in range(1500):
        (tmp_path / f"src/{number:04}").mkdir()
    robot = ElementTree.fromstring('<robot><joint name="left_hub"/><joint name="right_hub"/></robot>')
    assert controls(robot, file) == Controls()


def axes(text: str) -> list[str | None]:
    return [joint.findtext("axis/xyz") for joint in ElementTree.fromstring(text).findall("joint")]


def written(path: Path, text: str) -> Path:
    path.write_text(text, "utf-8")
    return path


@pytest.mark.parametrize("simulator", ["classic", "sim"])
def test_a_visual_without_its_mesh_is_left_out_of_a_drive_and_named(tmp_path: Path, simulator: str) -> None:
    """Gazebo Sim from Harmonic on refuses a world with a mesh that it does not find."""
    (tmp_path / "shell.stl").write_bytes(b"never read")
    visual = '<visual name="{0}"><geometry><mesh><uri>{1}</uri></mesh></geometry></visual>'
    visuals = visual.format("hull", "package://of_nobody/hull.dae") + visual.format("shell", "shell.stl")
    file = tmp_path / "mine.sdf"
    file.write_text(two_wheels(ROS_1).replace("</link>", f"{visuals}</link>", 1), "utf-8")
    found = from_file(file)
    assert re.findall(r'<visual name="(\w+)"', found.model("one", simulator)) == ["shell"]
    assert re.findall(r'<visual name="(\w+)"', found.file("one", simulator)) == ["hull", "shell"]
    assert "my_robot: left out for the drive, as their meshes are not found: hull" in list(found.notes(simulator))
