"""Names and types that Gazebo refuses are refused, and a robot that its file holds in the world drives away."""

from __future__ import annotations

import math
from pathlib import Path
from xml.etree.ElementTree import fromstring

import numpy as np
import pytest

from rsegen.errors import FileError
from rsegen.robots.files.sdf_file import SdfRobot, from_file
from rsegen.robots.files.sdf_names import refuse_unknown
from rsegen.robots.files.sdf_shapes import ModelFrames
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


def test_types_of_joints_may_have_large_letters(tmp_path: Path) -> None:
    robot = read(tmp_path, TURNS, TURNS.replace("revolute", "Revolute"))
    assert robot.drive == read(tmp_path).drive
    assert robot.text == read(tmp_path).text


def test_frames_of_parts_that_are_not_found_are_not_missed(tmp_path: Path) -> None:
    eye = '<link name="eye"><pose relative_to="mast">0 0 0.1 0 0 0</pose></link>'
    robot = read(tmp_path, TURNS, f"<include><uri>model://mast</uri></include>{eye}{TURNS}")
    assert any("model://mast" in remark for remark in robot.remarks)


def test_the_frame_of_a_nested_model_is_known_by_its_name(tmp_path: Path) -> None:
    mast = '<model name="mast"><pose>0 0 0.2 0 0 0.3</pose><link name="pole"/></model>'
    eye = '<link name="eye"><pose relative_to="mast::__model__">0.1 0 0 0 0 0</pose></link>'
    stand = '<joint name="stand" type="fixed"><parent>base</parent><child>mast::__model__</child></joint>'
    robot = read(tmp_path, TURNS, mast + eye + stand + TURNS)
    frames = robot.frames()
    assert frames.child("stand") == "mast::pole"
    turned = (0.1 * math.cos(0.3), 0.1 * math.sin(0.3), 0.2)
    assert frames.transform("eye")[:3, 3] == pytest.approx(turned)


def test_elements_of_plugins_are_no_references(tmp_path: Path) -> None:
    link = '<link name="base">'
    plugin = '<plugin filename="libmap.so" name="map"><pose relative_to="map">here</pose></plugin>'
    nested = '<model name="mast"><link name="pole">{}</link></model>'
    robot = read(tmp_path, link, nested.format(plugin) + link + plugin)
    assert '<pose relative_to="map">here</pose>' in robot.file("mine", "classic")


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


@pytest.mark.parametrize("is_nested", [False, True])
def test_what_is_placed_by_a_joint_to_the_world_stays_where_it_is(tmp_path: Path, *, is_nested: bool) -> None:
    pin = PINNED.replace("<parent>", '<pose relative_to="__model__">0.1 0 0.3 0 0 0.2</pose><parent>')
    text = two_wheels().replace("<pose>0 0 0.02", '<pose relative_to="pin">0 0 0.02').replace(TURNS, pin + TURNS)
    if is_nested:
        head, name, rest = text.partition('<model name="')
        text = f'{head}<model name="outer">{name}{rest}'.replace("</model>", "</model></model>")
    file = tmp_path / "mine.sdf"
    file.write_text(text)
    robot = from_file(file)
    assert "held in the world in its file by joint pin, and moves freely in a drive" in robot.remarks
    base = next(name for name, _ in robot.frames().links() if name.endswith("base"))
    for free in (robot.model("mine", "classic"), robot.model("mine", "sim"), robot.without_plugins("mine")):
        frames = ModelFrames(fromstring(free), "free")
        assert not any("world" in frames.parent(joint) for joint in frames.joints)
        there = next(name for name, _ in frames.links() if name.endswith("base"))
        np.testing.assert_allclose(frames.transform(there), robot.frames().transform(base), atol=1e-9)
        refuse_unknown(frames, is_whole=True)


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
