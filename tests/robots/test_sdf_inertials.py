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
from rsegen.robots.files.densities import weigh
from rsegen.robots.files.sdf_file import SdfRobot, from_file
from rsegen.robots.files.sdf_shapes import (
    Inertial,
    ModelFrames,
    extents,
    inertia_tensor,
    inertials,
    is_impossible,
)
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


SOLIDS = {
    "box": ("<box><size>0.3 0.2 0.1</size></box>", "box", "0.15 0.1 0.05"),
    "sphere": ("<sphere><radius>0.1</radius></sphere>", "sphere", "0.1"),
    "ellipsoid": ("<ellipsoid><radii>0.3 0.2 0.1</radii></ellipsoid>", "ellipsoid", "0.3 0.2 0.1"),
    "cylinder": ("<cylinder><radius>0.1</radius><length>0.3</length></cylinder>", "cylinder", "0.1 0.15"),
    "capsule": ("<capsule><radius>0.1</radius><length>0.3</length></capsule>", "capsule", "0.1 0.15"),
}


def assert_weighed_alike(text: str, geoms: str) -> None:
    """The masses of a link, by the densities of its shapes in SDF, are those of a body in MuJoCo."""
    mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")
    frames = ModelFrames(ElementTree.fromstring(f"<model name='m'>{text}</model>"), "m.sdf")
    assert weigh(frames) == ["a"]
    link = frames.elements["a"]
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody><body>{geoms}</body></worldbody></mujoco>")
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, model.body_iquat[1])
    tensor = turn.reshape(3, 3) @ np.diag(model.body_inertia[1]) @ turn.reshape(3, 3).T
    found = inertials(frames)["a"]
    assert found.mass == pytest.approx(model.body_mass[1], rel=1e-6)
    np.testing.assert_allclose(found.centre, model.body_ipos[1], atol=1e-7)
    np.testing.assert_allclose(inertia_tensor("a", link, frames), tensor, atol=1e-6 * model.body_inertia[1].max())


@pytest.mark.parametrize("solid", SOLIDS)
def test_links_are_weighed_by_the_densities_of_their_shapes_as_bodies_in_mujoco(solid: str) -> None:
    geometry, kind, size = SOLIDS[solid]
    shapes = (
        "<collision name='b'><pose>0.1 0.2 0.3 0.4 0 0</pose><density>700</density>"
        f"<geometry>{geometry}</geometry></collision>"
        f"<collision name='c'><pose>-0.2 0 0 0 0.7 0</pose><geometry>{geometry}</geometry></collision>"
    )
    inertial = "<inertial auto='True'><density>400</density><pose>9 9 9 0 0 0</pose></inertial>"
    geom = f"<geom type='{kind}' size='{size}'"
    geoms = (
        f"{geom} density='700' pos='0.1 0.2 0.3' euler='{np.degrees(0.4)} 0 0'/>"
        f"{geom} density='400' pos='-0.2 0 0' euler='0 {np.degrees(0.7)} 0'/>"
    )
    assert_weighed_alike(f"<link name='a'>{inertial}{shapes}</link>", geoms)


def test_meshes_and_cones_are_weighed_as_their_volumes(tmp_path: Path) -> None:
    trimesh = pytest.importorskip("trimesh", reason="trimesh is not installed")
    mesh = trimesh.creation.annulus(0.05, 0.1, 0.2).apply_translation([0.3, 0.1, 0])
    mesh.export(tmp_path / "ring.stl")
    uri = f"<uri>{tmp_path / 'ring.stl'}</uri><scale>1 2 1</scale>"
    frames = ModelFrames(
        ElementTree.fromstring(
            "<model name='m'><link name='a'><inertial auto='1'/><collision name='c'><geometry>"
            f"<mesh>{uri}</mesh></geometry></collision></link><link name='b'><inertial auto='1'/><collision name='c'>"
            "<geometry><cone><radius>0.1</radius><length>0.4</length></cone></geometry></collision></link></model>"
        ),
        "m.sdf",
    )
    assert weigh(frames) == ["a", "b"]
    cone = trimesh.creation.cone(0.1, 0.4, sections=720).apply_translation([0, 0, -0.2])
    for link, solid in (("a", mesh.apply_scale([1, 2, 1])), ("b", cone)):
        solid.density = 1000
        found = inertials(frames)[link]
        assert found.mass == pytest.approx(solid.mass, rel=1e-4)
        np.testing.assert_allclose(found.centre, solid.center_mass, atol=1e-6)
        tensor = inertia_tensor(link, frames.elements[link], frames)
        np.testing.assert_allclose(tensor, solid.moment_inertia, atol=1e-4 * solid.moment_inertia.max())


@pytest.mark.parametrize("mass", ["", "<mass>2</mass>"])
def test_a_robot_whose_inertials_gazebo_computes_is_driven_by_them(tmp_path: Path, mass: str) -> None:
    text = two_wheels(ROS_1).replace("<inertial><mass>3</mass>", f"<inertial auto='true'>{mass}", 1)
    robot = read(tmp_path, text)
    assert "weighed by the densities of their shapes, as Gazebo Sim does: base" in robot.remarks
    volume = 0.3 * 0.2 * 0.08 + 4 / 3 * np.pi * 0.02**3
    base = next(link for link in ElementTree.fromstring(robot.text).iter("link") if link.get("name") == "base")
    inertial = base.find("inertial")
    assert inertial is not None
    assert not inertial.attrib
    assert float(inertial.findtext("mass", "")) == pytest.approx(2 if mass else 1000 * volume)


@pytest.mark.parametrize(
    ("shape", "says"),
    [
        ("", "m.sdf: link 'a': its <inertial auto='true'> needs a collision shape"),
        (
            "<collision name='c'><density>-1</density><geometry><box><size>1 1 1</size></box></geometry></collision>",
            "m.sdf: link 'a': collision shape 'c': its density of -1 kg/m^3 is not positive",
        ),
        (
            "<collision name='c'><geometry><heightmap/></geometry></collision>",
            "m.sdf: link 'a': collision shape 'c': the mass of a <heightmap> is not computed; write the link's"
            " <inertial> without auto",
        ),
    ],
)
def test_what_cannot_be_weighed_is_refused(shape: str, says: str) -> None:
    model = ElementTree.fromstring(f"<model name='m'><link name='a'><inertial auto='1'/>{shape}</link></model>")
    with pytest.raises(FileError) as caught:
        weigh(ModelFrames(model, "m.sdf"))
    assert str(caught.value) == says


def test_a_mesh_that_is_inside_out_is_not_weighed(tmp_path: Path) -> None:
    trimesh = pytest.importorskip("trimesh", reason="trimesh is not installed")
    mesh = trimesh.creation.box((1, 1, 1))
    mesh.invert()
    mesh.export(tmp_path / "box.stl")
    shape = f"<geometry><mesh><uri>{tmp_path / 'box.stl'}</uri></mesh></geometry>"
    model = ElementTree.fromstring(
        f"<model name='m'><link name='a'><inertial auto='1'/><collision name='c'>{shape}</collision></link></model>"
    )
    with pytest.raises(FileError, match="has no volume, as it is not closed, or its faces point inwards; mend it"):
        weigh(ModelFrames(model, "m.sdf"))
