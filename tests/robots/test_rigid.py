"""Links on fixed joints, and turrets: parts of the robot that carries them, in a drive in Gazebo Classic."""

from __future__ import annotations

from pathlib import Path
from xml.etree.ElementTree import fromstring

import numpy as np
import pytest

from rsegen.robots.files.sdf_elements import Mass, sum_of_masses
from rsegen.robots.files.sdf_file import SdfRobot, from_file
from rsegen.robots.files.sdf_shapes import ModelFrames, inertia_tensor, inertials
from tests.robots.tracked_and_legged import tracked
from tests.robots.two_wheels import two_wheels

MAST = """\
    <link name="mast">
      <pose>0.1 0 0.2 0 0 0.5</pose>
      <inertial><pose>0 0 0.1 0 0 0</pose><mass>0.3</mass>
        <inertia><ixx>1e-3</ixx><ixy>2e-4</ixy><iyy>2e-3</iyy><izz>3e-3</izz></inertia></inertial>
      <collision name="tube">
        <pose>0 0 0.1 0 0 0</pose><geometry><box><size>0.02 0.02 0.2</size></box></geometry>
      </collision>
    </link>
    <joint name="foot" type="fixed"><parent>base</parent><child>mast</child></joint>
    <link name="lens">
      <pose relative_to="mast">0.05 0 0.2 0 0.3 0</pose>
      <inertial><mass>0.01</mass><inertia><ixx>1e-8</ixx><iyy>1e-8</iyy><izz>1e-8</izz></inertia></inertial>
      <collision name="tube"><geometry><sphere><radius>0.01</radius></sphere></geometry></collision>
    </link>
    <joint name="mount" type="fixed"><parent>mast</parent><child>lens</child></joint>
    <link name="flag"><pose>0.1 0 0.5 0 0 0</pose><inertial><mass>0.02</mass></inertial></link>
    <joint name="pole" type="revolute">
      <parent>lens</parent><child>flag</child><axis><xyz>0 1 0</xyz></axis>
    </joint>
"""

TURRET = """\
    <link name="turret">
      <pose>{x} 0 {z} 0 0 0</pose>
      <inertial><mass>0.01</mass><inertia><ixx>1e-8</ixx><iyy>1e-8</iyy><izz>1e-8</izz></inertia></inertial>
      <collision name="head"><geometry><sphere><radius>0.02</radius></sphere></geometry></collision>
    </link>
    <joint name="pan" type="revolute">
      <parent>base</parent><child>turret</child><axis><xyz>{axis}</xyz></axis>
    </joint>
"""


def carrying(folder: Path, more: str) -> SdfRobot:
    file = folder / "mine.sdf"
    file.write_text(two_wheels().replace('version="1.6"', 'version="1.7"').replace("</model>", f"{more}</model>"))
    return from_file(file)


def whole(frames: ModelFrames, links: tuple[str, ...]) -> Mass:
    """Links as one body, in the model's frame."""
    masses, elements = inertials(frames), dict(frames.links())
    places = {link: frames.transform(link) for link in links}
    for link in links:
        places[link] = places[link].copy()
        places[link][:3, 3] = masses[link].centre
    return sum_of_masses(
        (Mass(masses[link].mass, np.zeros(3), inertia_tensor(link, elements[link], frames)), places[link])
        for link in links
    )


def test_what_is_on_fixed_joints_is_a_part_of_what_carries_it_in_classic(tmp_path: Path) -> None:
    robot = carrying(tmp_path, MAST)
    made = ModelFrames(fromstring(robot.model("mine", "classic")), "made")
    own = robot.frames()
    assert [name for name, _ in made.links()] == ["base", "left_wheel", "right_wheel", "flag"]
    assert {name: made.parent(name) for name in made.joints} == dict.fromkeys(("left_hub", "right_hub", "pole"), "base")
    body, parts = whole(made, ("base",)), whole(own, ("base", "mast", "lens"))
    assert body.mass == pytest.approx(parts.mass)
    np.testing.assert_allclose(body.centre, parts.centre, atol=1e-9)
    np.testing.assert_allclose(body.tensor, parts.tensor, atol=1e-9)
    shapes = {shape.get("name"): made.shape("base", shape) for link, shape, _ in made.collisions() if link == "base"}
    there = [own.shape(link, shape) for link, shape, _ in own.collisions() if link in ("base", "mast", "lens")]
    assert len(shapes) == len(there) == 4
    np.testing.assert_allclose(list(shapes.values()), there, atol=1e-9)


@pytest.mark.parametrize("text", ["sim", "file"])
def test_elsewhere_links_on_fixed_joints_stay(tmp_path: Path, text: str) -> None:
    robot = carrying(tmp_path, MAST)
    model = fromstring(robot.model("mine", "sim") if text == "sim" else robot.file("mine", "classic"))
    assert {"mast", "lens"} <= {link.get("name") for link in model.iter("link")}


def test_tracks_stay_links(tmp_path: Path) -> None:
    file = tmp_path / "tracked.sdf"
    file.write_text(tracked())
    robot = from_file(file, tracks="left+left_flipper,right+right_flipper")
    links = {link.get("name", "") for link in fromstring(robot.model("mine", "classic")).iter("link")}
    assert {*robot.drive.left, *robot.drive.right} <= links


def test_a_fender_on_a_track_is_a_part_of_what_carries_the_track(tmp_path: Path) -> None:
    fender = """<link name="fender"><pose>0 0.18 0.2 0 0 0</pose><collision name="plate"><geometry><box>
      <size>0.4 0.06 0.01</size></box></geometry></collision></link>
      <joint name="screws" type="fixed"><parent>left</parent><child>fender</child></joint>"""
    (file := tmp_path / "tracked.sdf").write_text(tracked().replace("</model>", f"{fender}</model>"))
    model = fromstring(from_file(file, tracks="left,right").model("mine", "classic"))
    shapes = {link.get("name"): [shape.get("name") for shape in link.iter("collision")] for link in model.iter("link")}
    assert shapes["base"] == ["hull", "base_fixed_joint_lump__plate"]
    assert shapes["left"] == ["left_-1", "left_1", "left_between"]


def test_the_drive_of_tracks_names_the_link_that_its_body_is_a_part_of(tmp_path: Path) -> None:
    foot = """<link name="foot"><inertial><mass>0.1</mass></inertial></link>
      <joint name="stand" type="fixed"><parent>foot</parent><child>base</child></joint>"""
    (file := tmp_path / "tracked.sdf").write_text(tracked().replace("</model>", f"{foot}</model>"))
    robot = from_file(file, tracks="left,right")
    assert robot.drive.body == "base"  # type: ignore[attr-defined]
    model = fromstring(robot.model("mine", "classic"))
    assert model.findtext("plugin/body") == "foot"
    assert "base" not in {link.get("name") for link in model.iter("link")}


def test_a_gearbox_refers_to_the_link_that_its_reference_is_a_part_of(tmp_path: Path) -> None:
    gear = """<joint name="gear" type="gearbox"><parent>left_wheel</parent><child>right_wheel</child>
      <gearbox_ratio>-1</gearbox_ratio><gearbox_reference_body>lens</gearbox_reference_body>
      <axis><xyz>0 0 1</xyz></axis><axis2><xyz>0 0 1</xyz></axis2></joint>"""
    model = fromstring(carrying(tmp_path, MAST + gear).model("mine", "classic"))
    assert model.findtext("joint[@name='gear']/gearbox_reference_body") == "base"


def test_shapes_of_several_links_have_names_of_their_own(tmp_path: Path) -> None:
    def part(link: str, shape: str) -> str:
        solid = "<geometry><sphere><radius>0.01</radius></sphere></geometry>"
        return (
            f'<link name="{link}"><pose>0 0 0.2 0 0 0</pose><collision name="{shape}">{solid}</collision></link>'
            f'<joint name="{link}_joint" type="fixed"><parent>base</parent><child>{link}</child></joint>'
        )

    parts = [("top", "cap"), ("other", "b_cap"), ("a", "b_cap"), ("a_b", "cap")]
    model = fromstring(carrying(tmp_path, "".join(part(*names) for names in parts)).model("mine", "classic"))
    names = [shape.get("name") for shape in model.iterfind("link[@name='base']/collision")]
    assert len({*names}) == len(names) == 6


def test_a_circle_of_fixed_joints_stays(tmp_path: Path) -> None:
    back = '<joint name="back" type="fixed"><parent>lens</parent><child>base</child></joint>'
    robot = carrying(tmp_path, f"{MAST}{back}")
    links = {link.get("name") for link in fromstring(robot.model("mine", "classic")).iter("link")}
    assert {"base", "mast", "lens"} <= links


@pytest.mark.parametrize(
    ("x", "z", "axis", "held"),
    [
        (0.0, 0.3, "0 0 1", ("pan",)),
        (0.0, 0.3, "1 0 0", ("pan",)),  # a forearm, as Fetch has two
        (0.0, 0.3, "0 1 0", ()),  # rolls
        (-0.1, -0.01, "0 0 1", ()),  # a caster, also where it does not reach the ground on level floors
        (-0.1, 0.0, "0 0 1", ()),
    ],
)
def test_a_turret_is_held_and_a_caster_is_not(
    tmp_path: Path, x: float, z: float, axis: str, held: tuple[str, ...]
) -> None:
    assert carrying(tmp_path, TURRET.format(x=x, z=z, axis=axis)).held == held


def test_a_fork_with_a_wheel_is_not_held_however_high_it_is(tmp_path: Path) -> None:
    wheel = TURRET.replace("turret", "roller").replace("pan", "roll").replace("base", "turret")
    more = TURRET.format(x=0.2, z=0.2, axis="0 0 1") + wheel.format(x=0.2, z=0.15, axis="0 1 0")
    assert carrying(tmp_path, more).held == ()


def test_rollers_of_a_wheel_are_not_held_where_they_are_above_the_axle(tmp_path: Path) -> None:
    roller = TURRET.replace("base", "left_wheel").replace("turret", "roller{0}").replace("pan", "roll{0}")
    more = "".join(
        roller.replace("{0}", str(number)).format(x=x, z=z, axis=axis)
        for number, (x, z, axis) in enumerate([(0.0, 0.05, "1 0 0"), (0.04, 0.05, "0 0 1")])
    )
    assert carrying(tmp_path, more).held == ()
