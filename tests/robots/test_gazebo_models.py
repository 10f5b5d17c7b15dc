"""Models as a Gazebo reads them: their body is the link by which it says where they are, and Classic's are flat."""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree.ElementTree import Element, fromstring

import numpy as np
import pytest

from rsegen.errors import FileError
from rsegen.geometry.poses import rotation
from rsegen.robots.files.sdf_file import SdfRobot, from_file
from rsegen.robots.files.sdf_shapes import ModelFrames
from tests.robots.two_wheels import GZ, in_a_nested_model, two_wheels

BASE = re.compile(r'<link name="base">.*?</link>', re.DOTALL)

LATER = """\
    <model name="front">
      <pose degrees="true">0.1 0 0.03 0 0 30</pose>
      <frame name="mount"><pose relative_to="arm">0 0 0.01 0 0 0</pose></frame>
      <link name="arm">
        <pose rotation_format="quat_xyzw">0.02 0 0.05 0 0 1 1</pose>
        <inertial><pose degrees="true">0 0 0 0 90 0</pose><mass>0.1</mass>
          <inertia><ixx>1e-4</ixx><iyy>2e-4</iyy><izz>2e-4</izz></inertia></inertial>
        <collision name="box"><pose relative_to="__model__">0 0 0.1 0 0.1 0</pose>
          <geometry><box><size>0.1 0.02 0.02</size></box></geometry></collision>
      </link>
      <link name="tip">
        <pose relative_to="mount">0.1 0 0 0 0 0</pose>
        <inertial><mass>0.1</mass><inertia><ixx>1e-4</ixx><iyy>1e-4</iyy><izz>1e-4</izz></inertia></inertial>
      </link>
      <joint name="wrist" type="revolute">
        <pose degrees="true">0 0 0 10 20 30</pose>
        <parent>arm</parent><child>tip</child><axis><xyz expressed_in="mount">0 0.6 0.8</xyz></axis>
      </joint>
    </model>
    <joint name="shoulder" type="fixed"><parent>base</parent><child>front::arm</child></joint>
"""


def read(folder: Path, text: str) -> SdfRobot:
    file = folder / "mine.sdf"
    file.write_text(text)
    return from_file(file)


def wheels_first(version: str, canonical: str = "", scope: str = "") -> str:
    """The robot of two wheels with its base behind them, in a nested model if that has a name."""
    text = two_wheels().replace('version="1.6"', f'version="{version}"').replace("<parent>base", f"<parent>{scope}base")
    base = BASE.search(text)
    assert base is not None
    nested = f'<model name="{scope[:-2]}">{base[0]}</model>' if scope else base[0]
    text = text.replace(base[0], "").replace("</model>", f"{nested}</model>", 1)
    return re.sub("(<model [^>]*)>", rf'\1 canonical_link="{canonical}">', text, count=1) if canonical else text


def first_link(model: Element) -> str | None:
    return next(iter(model.findall("link"))).get("name")


@pytest.mark.parametrize(("version", "canonical"), [("1.6", ""), ("1.7", "left_wheel"), ("1.7", "base")])
@pytest.mark.parametrize("simulator", ["classic", "sim"])
def test_the_body_leads_although_wheels_stand_before_it(
    tmp_path: Path, simulator: str, version: str, canonical: str
) -> None:
    robot = read(tmp_path, wheels_first(version, canonical))
    for model in (
        fromstring(robot.model("mine", simulator)),
        *fromstring(robot.file("mine", simulator)).findall("model"),
    ):
        assert first_link(model) == "base"
        assert model.get("canonical_link", "base") == "base"
        assert sorted(link.get("name", "") for link in model.findall("link")) == ["base", "left_wheel", "right_wheel"]


def test_a_body_in_a_nested_model_leads(tmp_path: Path) -> None:
    robot = read(tmp_path, wheels_first("1.8", scope="in::"))
    model = fromstring(robot.model("mine", "sim"))
    assert model.get("canonical_link") == "in::base"
    assert [nested.get("canonical_link") for nested in model.findall("model")] == ["base"]
    assert first_link(fromstring(robot.model("mine", "classic"))) == "in::base"


def test_a_model_that_its_body_leads_stays(tmp_path: Path) -> None:
    robot = read(tmp_path, two_wheels())
    for simulator in ("classic", "sim"):
        assert [link.get("name") for link in fromstring(robot.model("mine", simulator)).findall("link")] == [
            "base",
            "left_wheel",
            "right_wheel",
        ]


def test_a_model_is_flat_in_classic_and_all_is_where_it_was(tmp_path: Path) -> None:
    text = two_wheels().replace('version="1.6"', 'version="1.11"')
    robot = read(tmp_path, "".join((*text.rpartition("</model>")[:1], LATER, *text.rpartition("</model>")[1:])))
    model = fromstring(robot.file("mine", "classic")).find("model")
    assert model is not None
    flat, own = ModelFrames(model, "flat"), ModelFrames(fromstring(robot.text), "own")
    assert model.find("model") is None
    assert model.find("frame") is None
    assert not any({*element.attrib} - {"name", "type", "filename"} for element in model.iter())
    assert [name for name, _ in flat.links()] == [name for name, _ in own.links()]
    assert [*flat.joints] == [*own.joints]
    for link, element in own.links():
        np.testing.assert_allclose(flat.transform(link), own.transform(link), atol=1e-9)
        twin = flat.elements[link]
        for tag in ("collision", "inertial"):
            for shape, other in zip(element.findall(tag), twin.findall(tag), strict=True):
                as_shape = tag == "collision"
                here = own.shape(link, shape) if as_shape else own.transform(link) @ own.local(shape)
                there = flat.shape(link, other) if as_shape else flat.transform(link) @ flat.local(other)
                np.testing.assert_allclose(there, here, atol=1e-9)
    for joint, element in flat.joints.items():
        ends = [element.findtext(tag) for tag in ("parent", "child")]
        assert ends == [own.parent(joint), own.child(joint)]
        place = own.transform(own.child(joint)) @ flat.local(element)
        np.testing.assert_allclose(place, own.joint(joint), atol=1e-9)
        if element.get("type") != "fixed":
            axis = [float(value) for value in (element.findtext("axis/xyz") or "").split()]
            np.testing.assert_allclose(place[:3, :3] @ axis, own.axis(joint), atol=1e-9)


def test_both_axes_are_where_they_were_in_a_flat_model(tmp_path: Path) -> None:
    axes = (
        '<axis><xyz expressed_in="tilt">1 0 0</xyz></axis>'
        "<axis2><xyz>0 1 0</xyz><use_parent_model_frame>true</use_parent_model_frame></axis2>"
        "<gearbox_reference_body>foot</gearbox_reference_body>"
    )
    mast = f"""<model name="mast"><pose>0 0 0.2 0 0 0.5</pose><link name="foot"/><link name="head"/>
      <frame name="tilt"><pose>0 0 0 0.1 0.2 0.3</pose></frame>
      <joint name="neck" type="universal"><pose>0 0 0 0 0.4 0</pose>
        <parent>foot</parent><child>head</child>{axes}</joint>
    </model><joint name="stand" type="fixed"><parent>base</parent><child>mast::foot</child></joint>"""
    robot = read(tmp_path, two_wheels().replace("</model>", f"{mast}</model>"))
    neck = next(
        joint for joint in fromstring(robot.file("mine", "classic")).iter("joint") if joint.get("name") == "mast::neck"
    )
    assert neck.findtext("gearbox_reference_body") == "mast::foot"
    assert neck.find(".//*[@expressed_in]") is None
    upright, place = rotation(0, 0, 0.5), robot.frames().joint("mast::neck")[:3, :3]
    for axis, direction in (("axis", (upright @ rotation(0.1, 0.2, 0.3))[:, 0]), ("axis2", upright[:, 1])):
        xyz = [float(value) for value in (neck.findtext(f"{axis}/xyz") or "").split()]
        np.testing.assert_allclose(place @ xyz, direction, atol=1e-9)


def test_plugins_of_nested_models_name_what_they_named_in_a_flat_model(tmp_path: Path) -> None:
    plugin = (
        '<plugin name="drive" filename="libmast.so"><joint_name>neck</joint_name><bodyName> head </bodyName>'
        "<robot_base_frame>foot</robot_base_frame><link_name>other</link_name></plugin>"
    )
    mast = f"""<model name="mast"><link name="foot"/><link name="head"/>
      <joint name="neck" type="fixed"><parent>foot</parent><child>head</child></joint>{plugin}</model>"""
    robot = read(tmp_path, two_wheels().replace("</model>", f"{mast}</model>"))
    model = fromstring(robot.file("mine", "classic")).find("model")
    assert model is not None
    moved = next(part for part in model.findall("plugin") if part.get("filename") == "libmast.so")
    assert [part.text for part in moved] == ["mast::neck", "mast::head", "foot", "other"]


def test_a_drive_in_gazebo_sim_finds_joints_of_nested_models(tmp_path: Path) -> None:
    robot = read(tmp_path, in_a_nested_model(two_wheels(GZ)).replace('version="1.6"', 'version="1.8"'))
    assert robot.drive.joints == ("inner::left_hub", "inner::right_hub")
    assert (robot.speed, robot.turn) == (0.3, 1.5)  # of its plug-in
    text = robot.model("mine", "sim")
    assert "::" not in re.sub("<plugin [^>]*>", "", text)
    model = fromstring(text)
    assert model.find("model") is None
    joints = [joint.get("name") for joint in model.findall("joint")]
    drive = next(plugin for plugin in model.findall("plugin") if plugin.get("filename") == "gz-sim-diff-drive-system")
    for side in ("left", "right"):
        assert drive.findtext(f"{side}_joint") == f"inner__{side}_hub"
        assert f"inner__{side}_hub" in joints
    assert first_link(model) == "inner__base"
    frames, flat = robot.frames(), ModelFrames(model, "")
    for name, _ in frames.links():
        np.testing.assert_allclose(flat.transform(name.replace("::", "__")), frames.transform(name), atol=1e-9)


NODDING = """
    <link name="head"><pose>0.1 0 0.3 0 0 0</pose></link>
    <joint name="nod" type="revolute"><parent>base</parent><child>head</child><axis><xyz>0 1 0</xyz></axis></joint>
    <link name="jaw"><pose>0.1 0 0.4 0 0 0</pose></link>
    <joint name="bite" type="revolute"><parent>head</parent><child>jaw</child><axis><xyz>0 1 0</xyz>
      <mimic joint="nod"><multiplier>2</multiplier></mimic></axis></joint>
    <plugin filename="gz-sim-wheel-slip-system" name="gz::sim::systems::WheelSlip">
      <wheel link_name="left_wheel"><wheel_radius>0.05</wheel_radius></wheel></plugin>
"""


def test_what_follows_a_joint_and_what_slips_has_its_name_in_a_flat_model(tmp_path: Path) -> None:
    text = two_wheels(f"{NODDING}{GZ}").replace('version="1.6"', 'version="1.11"')
    model = fromstring(read(tmp_path, in_a_nested_model(text)).model("mine", "sim"))
    followed = model.find("joint[@name='inner__bite']/axis/mimic")
    assert followed is not None
    assert followed.get("joint") == "inner__nod"
    wheel = model.find("plugin/wheel")
    assert wheel is not None
    assert wheel.get("link_name") == "inner__left_wheel"


def test_two_parts_that_would_have_one_name_in_a_flat_model_are_an_error(tmp_path: Path) -> None:
    text = in_a_nested_model(two_wheels(GZ)).replace('version="1.6"', 'version="1.8"')
    robot = read(tmp_path, text.replace("mast", "inner__base"))
    with pytest.raises(FileError, match="'inner::base' and 'inner__base' are both inner__base"):
        robot.model("mine", "sim")


def test_a_nested_robot_with_its_own_plugins_stays_nested_in_gazebo_sim(tmp_path: Path) -> None:
    robot = read(tmp_path, in_a_nested_model(two_wheels(GZ)).replace('version="1.6"', 'version="1.8"'))
    nested = fromstring(robot.file("mine", "sim")).find("model/model")
    assert nested is not None
    assert nested.findtext("plugin/left_joint") == "left_hub"


def test_a_joint_of_the_model_itself_on_a_nested_link_keeps_its_name(tmp_path: Path) -> None:
    text = two_wheels(GZ).replace('version="1.6"', 'version="1.8"')
    wheel = re.search(r'<link name="left_wheel">.*?</link>', text, re.DOTALL)
    assert wheel is not None
    inside = f'<model name="inner">{wheel[0]}</model>'
    text = text.replace(wheel[0], inside).replace("<child>left_wheel", "<child>inner::left_wheel")
    model = fromstring(read(tmp_path, text).model("mine", "sim"))
    assert model.findtext("plugin/left_joint") == "left_hub"
    assert [joint.findtext("child") for joint in model.findall("joint")] == ["inner__left_wheel", "right_wheel"]
