"""Files that simulators load and strict readers do not: prefixes, comments, shapes without a size."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from rsegen.errors import FileError
from rsegen.robots.sdf_file import from_file
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
