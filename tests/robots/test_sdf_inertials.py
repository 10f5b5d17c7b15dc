"""Masses of a model are found at their places; those that no simulator takes are refused, odd ones are noted."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rsegen.errors import FileError
from rsegen.geometry.poses import rotation
from rsegen.robots.base import ROBOTS
from rsegen.robots.files.sdf_file import SdfRobot, from_file
from rsegen.robots.files.sdf_shapes import Inertial, ModelFrames, extents, inertials, is_impossible
from tests.robots.two_wheels import ROS_1, two_wheels

INERTIAL = "<inertial>{}</inertial>"


def of(links: str) -> dict[str, Inertial]:
    return inertials(ModelFrames(ElementTree.fromstring(f"<model name='m'>{links}</model>"), "m.sdf"))


def read(folder: Path, text: str) -> SdfRobot:
    path = folder / "mine.sdf"
    path.write_text(text, "utf-8")
    return from_file(path)


@pytest.mark.parametrize("kind", list(ROBOTS))
def test_masses_of_our_own_robots_are_found_where_they_are(kind: str) -> None:
    robot = ROBOTS[kind]
    found = inertials(ModelFrames(ElementTree.fromstring(robot.model("one")), kind))
    assert {name: each.mass for name, each in found.items()} == pytest.approx(
        {link.name: link.mass for link in robot.links}, rel=1e-6
    )
    for link in robot.links:
        centre = rotation(*link.pose[3:]) @ link.centre[:3] + link.pose[:3]
        np.testing.assert_allclose(found[link.name].centre, centre, atol=1e-9)


def test_a_centre_is_in_the_frame_of_the_model_and_defaults_are_those_of_sdf() -> None:
    quarter = f"<pose>1 2 3 0 0 {np.pi / 2}</pose>"
    found = of(
        f"<link name='a'>{quarter}{INERTIAL.format('<pose>1 0 0 0 0 0</pose><mass>2</mass>')}</link>"
        f"<link name='b'><pose relative_to='a'>0 1 0 0 0 0</pose></link>"
        f"<model name='n'><pose>5 0 0 0 0 0</pose><link name='c'>{INERTIAL.format('')}</link></model>"
    )
    assert {name: each.mass for name, each in found.items()} == {"a": 2, "b": 1, "n::c": 1}
    for name, centre in (("a", (1, 3, 3)), ("b", (0, 2, 3)), ("n::c", (5, 0, 0))):
        np.testing.assert_allclose(found[name].centre, centre, atol=1e-9)


def test_a_shape_in_a_nested_model_may_be_relative_to_that_model() -> None:
    pose = "<pose relative_to='__model__'>0 0 2 0 0 0</pose>"
    collision = f"<collision name='s'>{pose}<geometry><sphere><radius>1</radius></sphere></geometry></collision>"
    link = f"<link name='c'><pose>1 0 0 0 0 0</pose>{collision}</link>"
    model = ElementTree.fromstring(f"<model name='m'><model name='n'><pose>5 0 0 0 0 0</pose>{link}</model></model>")
    (extent,) = extents(ModelFrames(model, "m.sdf")).known.values()
    np.testing.assert_allclose([extent.low, extent.high], [(4, -1, 1), (6, 1, 3)], atol=1e-12)


@pytest.mark.parametrize(
    ("inner", "says"),
    [
        ("<mass>0</mass>", "m.sdf: link 'a': a mass of 0 kg is not above 0"),
        ("<mass>-2</mass>", "m.sdf: link 'a': a mass of -2 kg is not above 0"),
        ("<mass>nan</mass>", "m.sdf: link 'a': 'nan' is not a number within a million"),
        ("<mass>inf</mass>", "m.sdf: link 'a': 'inf' is not a number within a million"),
        ("<inertia><ixx>-1</ixx></inertia>", "m.sdf: link 'a': a principal moment of inertia of -1 kg m^2 is negative"),
        ("<inertia><ixy>2</ixy></inertia>", "m.sdf: link 'a': a principal moment of inertia of -1 kg m^2 is negative"),
        ("<inertia><izz>nan</izz></inertia>", "m.sdf: link 'a': 'nan' is not a number within a million"),
    ],
)
def test_a_mass_or_moment_that_cannot_be_is_refused_in_one_line(inner: str, says: str) -> None:
    with pytest.raises(FileError) as caught:
        of(f"<link name='a'>{INERTIAL.format(inner)}</link>")
    assert str(caught.value) == says


def test_moments_that_no_body_has_are_noted_and_the_robot_is_driven(tmp_path: Path) -> None:
    text = two_wheels(ROS_1).replace("<ixx>0.02</ixx>", "<ixx>0.002</ixx>")
    robot = read(tmp_path, text)
    assert robot.drive
    assert "no body has the moments of inertia of base; Gazebo Sim may refuse them" in list(robot.notes("classic"))[1]
    assert read(tmp_path, two_wheels(ROS_1)).remarks == ()


@given(st.lists(st.tuples(*[st.floats(-1, 1)] * 3, st.floats(0.01, 1)), min_size=2, max_size=6), st.integers(2, 6))
def test_moments_of_point_masses_are_possible_and_rounding_makes_them_no_others(
    points: list[tuple[float, float, float, float]], digits: int
) -> None:
    """All of rods and plates, which meet the triangle inequality exactly, to two digits or more along their axes."""
    places, masses = np.array([point[:3] for point in points]), np.array([point[3] for point in points])
    ways = places - masses @ places / masses.sum()
    tensor = sum(m * (way @ way * np.eye(3) - np.outer(way, way)) for m, way in zip(masses, ways, strict=True))
    assert not is_impossible(np.asarray(tensor))
    moments = [float(f"{moment:.{digits}e}") for moment in np.linalg.eigvalsh(tensor)]
    assert not is_impossible(np.diag(moments))
    turn = rotation(0.1, 0.2, 0.3)
    assert is_impossible(turn @ np.diag([1, 1, 2.1]) @ turn.T)


@pytest.mark.parametrize("mass", ["", "<mass>2</mass>"])
def test_an_inertial_that_gazebo_computes_is_refused(tmp_path: Path, mass: str) -> None:
    text = two_wheels(ROS_1).replace("<inertial><mass>3</mass>", f"<inertial auto='true'>{mass}", 1)
    with pytest.raises(FileError, match="link 'base': its <inertial auto='true'> is computed by Gazebo Sim"):
        read(tmp_path, text)
