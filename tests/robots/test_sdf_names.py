"""Names and types that Gazebo refuses are refused, and a robot that its file holds in the world drives away."""

from __future__ import annotations

from pathlib import Path
from xml.etree.ElementTree import fromstring

import pytest

from rsegen.errors import FileError
from rsegen.robots.sdf_file import SdfRobot, from_file
from tests.robots.two_wheels import two_wheels
from tests.robots.urdf_robots import two_wheels_urdf


def read(folder: Path, old: str = "", new: str = "") -> SdfRobot:
    """The robot of two wheels, with something else in one place of its file."""
    text = two_wheels()
    assert old in text
    file = folder / "mine.sdf"
    file.write_text(text.replace(old, new, 1))
    return from_file(file)


TURNS = '<joint name="left_hub" type="revolute">'


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("<child>left_wheel</child>", "<child>wheel</child>", "joint 'left_hub': there is no link 'wheel'"),
        ("<parent>base</parent>", "<parent>hull</parent>", "joint 'left_hub': there is no link 'hull'"),
        ("<parent>base</parent>", "", "joint 'left_hub': it has no <parent>"),
        (TURNS, TURNS.replace("revolute", "wheel"), "joint 'left_hub': its type 'wheel' is none of revolute, "),
        (TURNS, TURNS.replace(' type="revolute"', ""), "joint 'left_hub': its type '' is none of revolute, "),
        ("<pose>0 0 0.02", "<pose relative_to='deck'>0 0 0.02", "relative_to='deck' at 'base': there is no such link,"),
        ("<pose>-0.05 0", "<pose relative_to='deck'>-0.05 0", "relative_to='deck' at 'base': there is no such link,"),
        ("<xyz>", "<xyz expressed_in='deck'>", "expressed_in='deck' at 'left_hub': there is no such link,"),
        (TURNS, f"<frame name='a' attached_to='deck'/>{TURNS}", "attached_to='deck' at 'a': there is no such link,"),
    ],
)
def test_what_a_model_has_not_is_refused(tmp_path: Path, old: str, new: str, problem: str) -> None:
    with pytest.raises(FileError, match=problem):
        read(tmp_path, old, new)


def test_frames_of_parts_that_are_not_found_are_not_missed(tmp_path: Path) -> None:
    eye = '<link name="eye"><pose relative_to="mast">0 0 0.1 0 0 0</pose></link>'
    robot = read(tmp_path, TURNS, f"<include><uri>model://mast</uri></include>{eye}{TURNS}")
    assert any("model://mast" in remark for remark in robot.remarks)


PINNED = '<joint name="pin" type="fixed"><parent>world</parent><child>base</child></joint>'


@pytest.mark.parametrize(
    ("held", "how"), [("<static>true</static>", "<static>"), (PINNED, "joint pin")], ids=["static", "pinned"]
)
def test_a_robot_that_is_held_in_the_world_moves_freely_in_a_drive(tmp_path: Path, held: str, how: str) -> None:
    robot = read(tmp_path, TURNS, held + TURNS)
    note = f"held in the world in its file by {how}, and moves freely in a drive"
    assert note in robot.remarks
    free = read(tmp_path)
    for simulator in ("classic", "sim"):
        assert robot.model("mine", simulator) == free.model("mine", simulator)
        assert ("static" in robot.file("mine", simulator)) == ("static" in held)
    assert robot.without_plugins("mine") == free.without_plugins("mine")


def test_a_robot_on_a_link_called_world_moves_freely_in_a_drive(tmp_path: Path) -> None:
    text = two_wheels_urdf("")
    pin = '<joint name="pin" type="fixed"><parent link="world"/><child link="base_footprint"/></joint>'
    file = tmp_path / "mine.urdf"
    file.write_text(text.replace("</robot>", f'<link name="world"/>{pin}</robot>'))
    robot = from_file(file)
    assert "held in the world in its file by joint pin, and moves freely in a drive" in robot.remarks
    ends = {joint.findtext("parent") for joint in fromstring(robot.model("mine", "sim")).findall("joint")}
    assert ends == {"base_footprint"}


def test_an_axis_without_a_direction_is_the_z_of_its_joint(tmp_path: Path) -> None:
    robot = read(tmp_path, "<axis><xyz>0 0 1</xyz></axis>", "<axis><dynamics><damping>0.1</damping></dynamics></axis>")
    assert robot.drive.left == ("left_hub",)
