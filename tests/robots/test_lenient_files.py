"""Files that simulators load and strict readers do not: prefixes, comments, shapes without a size."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from rsegen.errors import FileError
from rsegen.robots.files.sdf_file import SdfRobot, from_file
from rsegen.robots.lookup import robot_of
from tests.robots.two_wheels import two_wheels
from tests.robots.urdf_robots import two_wheels_urdf


def read_as(tmp_path: Path, name: str, text: str) -> tuple[float, ...]:
    file = tmp_path / name
    file.write_text(text, "utf-8")
    robot = from_file(file)
    return (*robot.size, robot.body.mass, robot.drive.separation, robot.drive.radius)


@pytest.mark.parametrize(
    "changed",
    [
        lambda text: text.replace("<model", '<model gz:expressed_in="base"', 1),
        lambda text: text.replace("<link", "<drake:part>1</drake:part><link", 1),
        lambda text: text.replace("<link", "<controller:old_laser name='a'/><link", 1),
        lambda text: "\n  " + text.replace("<link", "<!-- wide -- and -- long --->\n<link", 1),
        lambda text: text.replace("<link", "<author>Black & White</author><link", 1),
        lambda text: text.replace("<link", "<!-- <ignition:odd> --><ignition:a b='c'/><link", 1),
    ],
)
def test_a_file_that_is_no_strict_xml_is_the_same_robot(tmp_path: Path, changed: Callable[[str], str]) -> None:
    text = two_wheels()
    assert changed(text) != text
    assert read_as(tmp_path, "a.sdf", changed(text)) == read_as(tmp_path, "b.sdf", text)


def test_a_prefix_is_written_as_gazebo_knows_it(tmp_path: Path) -> None:
    file = tmp_path / "a.sdf"
    direction = "<surface><friction><ode><fdir1 gz:expressed_in='base'>1 1 0</fdir1></ode></friction></surface>"
    file.write_text(two_wheels().replace("</collision>", f"{direction}</collision>"), "utf-8")
    robot = from_file(file)
    assert 'gz:expressed_in="base"' in robot.model("one", "sim")
    file.write_text(file.read_text().replace("<sdf", "<sdf xmlns:gz='http://gazebosim.org/schema'"), "utf-8")
    assert 'gz:expressed_in="base"' in from_file(file).model("one", "sim")


@pytest.mark.parametrize(
    "shape",
    [
        '<sphere radius="0"/>',
        '<box size="0.1 0 0.1"/>',
        '<cylinder radius="0" length="1"/>',
        '<cylinder radius="1" length="0"/>',
    ],
)
def test_a_shape_without_a_size_is_left_out_and_named(tmp_path: Path, shape: str) -> None:
    text = two_wheels_urdf()
    flat = text.replace("</link>", f'<collision name="dot"><geometry>{shape}</geometry></collision></link>')
    assert flat.count(shape) > 2
    assert read_as(tmp_path, "a.urdf", flat) == read_as(tmp_path, "b.urdf", text)
    remarks = from_file(tmp_path / "a.urdf").remarks
    assert any("these collision shapes have no size" in remark and "dot" in remark for remark in remarks)


@pytest.mark.parametrize(
    ("shape", "says"),
    [
        ('<sphere radius="-0.1"/>', "the radius -0.1 m of its sphere is below 0"),
        ('<box size="0.1 -2 0.1"/>', "the size -2 m of its box is below 0"),
        ('<cylinder radius="0.1" length="-1"/>', "the length -1 m of its cylinder is below 0"),
    ],
)
def test_a_size_below_0_is_one_line(tmp_path: Path, shape: str, says: str) -> None:
    file = tmp_path / "a.urdf"
    file.write_text(two_wheels_urdf().replace("</link>", f"<collision><geometry>{shape}</geometry></collision></link>"))
    with pytest.raises(FileError, match=f"a.urdf: link .*{says}"):
        from_file(file)


@pytest.mark.parametrize("name", ["ROBOT.URDF", "robot.xml", "robot.Urdf"])
def test_a_robot_is_known_by_what_is_in_its_file(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text(two_wheels_urdf())
    robot = robot_of(str(tmp_path / name))
    assert isinstance(robot, SdfRobot)
    assert robot.body.mass == pytest.approx(3.4)


@pytest.mark.parametrize(
    ("name", "text", "says"),
    [
        ("go2.xml", "<mujoco/>", "a scene of MuJoCo without a <body>, so without a robot"),
        ("a.sdf", "<sdf><world><model name='a'/></world></sdf>", "a world; use the SDF file of the robot alone"),
        ("a.sdf", "<sdf><model name='a'/><model name='b'/></sdf>", "nor URDF: there are 2 in <sdf>"),
        ("page.xml", "<html/>", "not an SDF file with one <model> in <sdf>, nor URDF: it begins with <html>"),
        ("robot.proto", "", "a PROTO of Webots; export it as URDF there, and use that file"),
        ("robot.wbt", "", "robots are read from files named *.sdf, *.urdf, *.xacro, *.xml, *.mjcf"),
    ],
)
def test_what_is_no_robot_is_one_line_that_says_what_it_is(tmp_path: Path, name: str, text: str, says: str) -> None:
    (tmp_path / name).write_text(text)
    with pytest.raises(FileError) as caught:
        robot_of(str(tmp_path / name))
    assert says in str(caught.value)
    assert str(caught.value).startswith(f"{tmp_path / name}: ")


@pytest.mark.parametrize(
    ("uri", "says"),
    [
        ("file:///nowhere/tyre.stl", "there is no such file"),
        ("meshes/tyre.stl", "there is no such file"),
        ("https://fuel.gazebosim.org/1.0/tyre.stl", "rsegen fetches nothing itself; download it"),
        ("package://my_description/meshes/tyre.stl", "there is no meshes/tyre.stl in {folder}/my_description"),
        ("package://nobodys_description/tyre.stl", "put its package next to that of the file"),
    ],
)
def test_a_mesh_that_is_missing_is_named_with_what_is_missing(tmp_path: Path, uri: str, says: str) -> None:
    (tmp_path / "my_description/urdf").mkdir(parents=True)
    (tmp_path / "my_description/my_description").mkdir()  # as packages with Python have one
    (tmp_path / "my_description/package.xml").write_text("<package><name>my_description</name></package>")
    file = tmp_path / "my_description/urdf/a.urdf"
    shape = f'<collision><geometry><mesh filename="{uri}"/></geometry></collision></link>'
    file.write_text(two_wheels_urdf().replace("</link>", shape, 1))
    with pytest.raises(FileError) as caught:
        from_file(file)
    assert f"a.urdf: the mesh {uri} of a collision shape is not found; " in str(caught.value)
    assert str(caught.value).partition("; ")[2].startswith(says.format(folder=tmp_path))
    assert not str(caught.value).endswith("my_description/my_description")
