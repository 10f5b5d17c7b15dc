"""Visual shapes of robots as triangles, measured by trimesh, and against the boxes around them."""

from __future__ import annotations

from pathlib import Path
from xml.etree.ElementTree import fromstring

import numpy as np
import pytest
import trimesh

from rsegen.robots import visuals as module
from rsegen.robots.base import ROBOTS
from rsegen.robots.files.sdf_shapes import ModelFrames, swept_box
from rsegen.robots.links import DARK
from rsegen.robots.lookup import robot_of
from rsegen.robots.visuals import visuals

SHAPES = {
    "<box><size>0.4 0.2 0.1</size></box>": 0.008,
    "<sphere><radius>0.1</radius></sphere>": 4 / 3 * np.pi * 1e-3,
    "<cylinder><radius>0.1</radius><length>0.3</length></cylinder>": np.pi * 3e-3,
    "<capsule><radius>0.1</radius><length>0.3</length></capsule>": np.pi * (3e-3 + 4e-3 / 3),
    "<cone><radius>0.1</radius><length>0.3</length></cone>": np.pi * 1e-3,
    "<ellipsoid><radii>0.1 0.2 0.3</radii></ellipsoid>": 4 / 3 * np.pi * 6e-3,
}


@pytest.mark.parametrize("text", SHAPES)
def test_a_shape_is_closed_and_as_large_as_it_is(text: str) -> None:
    geometry = fromstring(f"<geometry>{text}</geometry>")
    points, corners = module._triangles(geometry[0], "test")
    mesh = trimesh.Trimesh(points, corners)  # merges equal points, and leaves out what has no area
    mesh.update_faces(mesh.nondegenerate_faces())
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert 0.85 * SHAPES[text] < mesh.volume <= 1.0001 * SHAPES[text]
    box = swept_box(geometry, "test")
    assert box is not None
    half = np.add(box.half, box.radii)
    assert (np.abs(points) <= half + 1e-9).all()
    assert np.abs(points).max(axis=0) == pytest.approx(half, rel=0.05)


@pytest.mark.parametrize("kind", ROBOTS)
def test_a_robot_is_as_large_as_its_visual_shapes(kind: str) -> None:
    robot = robot_of(kind)
    frames = ModelFrames(fromstring(robot.without_plugins("robot")), kind)
    shapes = visuals(robot)
    assert shapes.keys() == {link for link, _ in frames.links()}
    placed = [
        shape.points @ pose[:3, :3].T + pose[:3, 3]
        for link, parts in shapes.items()
        for pose in [frames.transform(link)]
        for shape in parts
    ]
    points = np.concatenate(placed)
    length, width, height = np.ptp(points, axis=0)
    assert (length, width, height) == pytest.approx(robot.size, rel=0.1)
    colours = {shape.colour for parts in shapes.values() for shape in parts}
    assert len(colours) > 1
    assert all(0 <= part <= 1 for colour in colours for part in colour)


MODEL = """<sdf version="1.7"><model name="cart">
  <link name="base">
    <inertial><mass>1</mass></inertial>
    <collision name="hull"><geometry><box><size>0.3 0.2 0.1</size></box></geometry></collision>
    {visual}
  </link>
  {wheels}
</model></sdf>"""
WHEEL = """<link name="{side}"><pose>0 {y} 0 -1.5708 0 0</pose><inertial><mass>0.1</mass></inertial>
  <collision name="tread"><geometry><cylinder><radius>0.08</radius><length>0.03</length></cylinder></geometry>
  </collision></link><joint name="{side}_joint" type="revolute"><parent>base</parent><child>{side}</child>
  <axis><xyz>0 0 1</xyz></axis></joint>"""
WHEELS = "".join(WHEEL.format(side=side, y=y) for side, y in (("left", 0.12), ("right", -0.12)))


def cart(folder: Path, visual: str) -> Path:
    file = folder / "cart.sdf"
    file.write_text(MODEL.format(visual=visual, wheels=WHEELS))
    return file


@pytest.mark.parametrize(
    "visual", ["", "<visual name='v'><geometry><mesh><uri>gone.stl</uri></mesh></geometry></visual>"]
)
def test_a_link_without_visuals_that_can_be_read_has_its_collision_shapes(visual: str, tmp_path: Path) -> None:
    (hull,) = visuals(robot_of(cart(tmp_path, visual)))["base"]
    assert np.ptp(hull.points, axis=0) == pytest.approx((0.3, 0.2, 0.1))


def test_visuals_of_a_file_have_their_colours_and_wheels_without_one_are_dark(tmp_path: Path) -> None:
    colour = "<material><diffuse>0.1 0.7 0.2 1</diffuse></material>"
    visual = f"<visual name='v'><geometry><sphere><radius>0.1</radius></sphere></geometry>{colour}</visual>"
    shapes = visuals(robot_of(cart(tmp_path, visual)))
    assert [shape.colour for shape in shapes["base"]] == [(0.1, 0.7, 0.2)]
    assert {shape.colour for shape in shapes["left"] + shapes["right"]} == {DARK}


def test_a_mesh_is_drawn_as_it_is(tmp_path: Path) -> None:
    trimesh.creation.icosphere(radius=50.0).export(tmp_path / "ball.stl")
    uri = f"<uri>file://{tmp_path}/ball.stl</uri><scale>0.001 0.001 0.001</scale>"
    visual = f"<visual name='v'><geometry><mesh>{uri}</mesh></geometry></visual>"
    (ball,) = visuals(robot_of(cart(tmp_path, visual)))["base"]
    assert trimesh.Trimesh(ball.points, ball.corners).volume == pytest.approx(4 / 3 * np.pi * 0.05**3, rel=0.02)
