"""Shapes that a Gazebo lacks, or in which it is wrong: in those that it has, the same in space, or refused."""

from __future__ import annotations

from pathlib import Path
from xml.etree.ElementTree import Element, fromstring

import numpy as np
import pytest

from rsegen.errors import FileError
from rsegen.robots.base import ROBOTS
from rsegen.robots.files.sdf_file import from_file
from rsegen.robots.lookup import DrivableRobot
from tests.robots.mjcf_robots import two_wheels_mjcf
from tests.robots.two_wheels import ROS_1, two_wheels

FOOT = """\
<{tag} name="foot"><pose{degrees}>0.1 0 0.05 0 {quarter} 0</pose>
  <geometry><{kind}>{sizes}</{kind}></geometry>
</{tag}>
"""


def robot_with(folder: Path, kind: str, sizes: str, tag: str = "collision", *, degrees: bool = False) -> Path:
    """Write a robot with a shape more, on its side, and return its file."""
    turned = (' degrees="true"', "90") if degrees else ("", str(np.pi / 2))
    foot = FOOT.format(tag=tag, kind=kind, sizes=sizes, degrees=turned[0], quarter=turned[1])
    file = folder / "mine.sdf"
    text = two_wheels()
    assert text.count("</link>") > 1
    file.write_text(text.replace("</link>", f"{foot}</link>", 1))
    return file


def shapes(text: str, tag: str = "collision") -> dict[str, Element]:
    return {
        shape.get("name", ""): shape for shape in fromstring(text).iter(tag) if shape.get("name", "").startswith("foot")
    }


@pytest.mark.parametrize("degrees", [False, True])
@pytest.mark.parametrize("tag", ["collision", "visual"])
def test_a_capsule_is_a_cylinder_with_a_ball_at_each_end(tmp_path: Path, tag: str, degrees: bool) -> None:
    sizes = "<radius>0.02</radius><length>0.06</length>"
    robot = from_file(robot_with(tmp_path, "capsule", sizes, tag, degrees=degrees))
    text = robot.model("mine", "classic")
    found = shapes(text, tag)
    assert {name: next(shape.iterfind("geometry/*")).tag for name, shape in found.items()} == {
        "foot": "cylinder",
        "foot_top": "sphere",
        "foot_bottom": "sphere",
    }
    for name, x in (("foot", 0.1), ("foot_top", 0.13), ("foot_bottom", 0.07)):
        values = [float(value) for value in (found[name].findtext("pose") or "").split()]
        assert values == pytest.approx([x, 0, 0.05, 0, np.pi / 2, 0])
        assert [pose.attrib for pose in found[name].iterfind("pose")] == [{}]
    assert shapes(robot.model("mine", "sim"), tag)["foot"].find("geometry/capsule") is not None
    assert "capsule" not in robot.file("mine", "classic")


def test_an_even_ellipsoid_is_a_ball_and_another_one_is_refused_where_it_touches(tmp_path: Path) -> None:
    even = from_file(robot_with(tmp_path, "ellipsoid", "<radii>0.02 0.02 0.02</radii>"))
    assert shapes(even.model("mine"))["foot"].findtext("geometry/sphere/radius") == "0.02"
    flat = from_file(robot_with(tmp_path, "ellipsoid", "<radii>0.02 0.02 0.01</radii>"))
    with pytest.raises(
        FileError, match="collision shape 'foot' is of the type ellipsoid, which Gazebo Classic does not"
    ):
        flat.model("mine", "classic")
    assert "ellipsoid" in flat.model("mine", "sim")
    assert (
        shapes(
            from_file(robot_with(tmp_path, "cone", "<radius>0.1</radius><length>1</length>", "visual")).model("m"),
            "visual",
        )
        == {}
    )


def test_the_damping_that_a_motor_of_mujoco_overcomes_does_not_brake_the_wheels_of_classic(tmp_path: Path) -> None:
    robot = from_file(two_wheels_mjcf(tmp_path))

    def dampings(text: str) -> list[str | None]:
        hubs = [joint for joint in fromstring(text).iter("joint") if "hub" in joint.get("name", "")]
        assert len(hubs) == 2
        assert all(hub.findtext("physics/ode/implicit_spring_damper") == "true" for hub in hubs)
        return [hub.findtext("axis/dynamics/damping") for hub in hubs]

    assert dampings(robot.model("rover", "classic")) == [None, None]
    assert dampings(robot.model("rover", "sim")) == ["0.01", "0.01"]


@pytest.mark.parametrize(("torque", "stays"), [(5, False), (0.3, True)])
def test_the_friction_of_joints_brakes_wheels_of_classic_only_where_their_motors_are_weaker(
    tmp_path: Path, torque: float, *, stays: bool
) -> None:
    rubs = "<dynamics><damping>0.1</damping><friction>0.4</friction></dynamics>"
    plugin = ROS_1.replace("<torque>5", f"<torque>{torque}")
    file = tmp_path / "mine.sdf"
    file.write_text(two_wheels(plugin).replace("</xyz></axis>", f"</xyz>{rubs}</axis>"))
    robot = from_file(file)
    for backend, is_there in (("classic", stays), ("sim", True)):
        hubs = list(fromstring(robot.model("rover", backend)).iter("joint"))
        assert [hub.findtext("axis/dynamics/friction") for hub in hubs] == ["0.4" if is_there else None] * 2
        assert [hub.findtext("axis/dynamics/damping") for hub in hubs] == ["0.1" if is_there else None] * 2


@pytest.mark.parametrize("backend", ["sim", "fortress"])
@pytest.mark.parametrize("name", ["burger", "of a file"])
def test_balls_that_touch_are_capsules_in_gazebo_sim(tmp_path: Path, name: str, backend: str) -> None:
    robot: DrivableRobot = from_file(two_wheels_mjcf(tmp_path)) if name == "of a file" else ROBOTS[name]

    def solids(simulator: str, tag: str) -> list[Element]:
        return [next(shape.iterfind("geometry/*")) for shape in fromstring(robot.model("mine", simulator)).iter(tag)]

    balls = 0
    for had, has in zip(solids("classic", "collision"), solids(backend, "collision"), strict=True):
        balls += had.tag == "sphere"
        assert has.tag == ("capsule" if had.tag == "sphere" else had.tag)
        assert has.findtext("radius") == had.findtext("radius")
        assert float(has.findtext("length") or 0) < 1e-4 or had.tag == "cylinder"
    assert balls
    assert "capsule" not in {look.tag for look in solids(backend, "visual")}
