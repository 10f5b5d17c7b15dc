"""Visuals of a map with robots in a window of MuJoCo: meshes in colours, and light.

A drive has collision shapes alone; only a window adds what is seen, so that drives stay as fast as they are. Meshes of
a map are of one colour each, so their number does not grow with the map. Collision shapes are in group 3, which a
window hides until somebody presses 3.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import atan, degrees, tan
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from rsegen.field.stepfield import Array, Ints
from rsegen.geometry.exposed_faces import surface
from rsegen.mujoco.robot_model import RobotModel, numbers
from rsegen.pictures.camera import south_west_of
from rsegen.robots.visuals import visuals
from rsegen.scene.colours import Colour
from rsegen.scene.scene import Scene
from rsegen.simulators.embedded import PlacedRobot

_SEEN = {"contype": "0", "conaffinity": "0", "group": "2", "mass": "0"}
"""A shape that is seen, and touches nothing."""

_HIDDEN = "3"
"""The group of collision shapes."""

_GROUND = "0.7 0.7 0.7 1"


def add_looks(root: Element, scene: Scene, placed: Sequence[PlacedRobot], robots: Sequence[RobotModel]) -> None:
    """Add visual shapes, colours and light to a model; its ground is its first shape."""
    world, assets = (_part(root, name) for name in ("worldbody", "asset"))
    # A plane has no visual of its own, so the ground is coloured; all other collision shapes are hidden.
    for index, geom in enumerate(world.iter("geom")):
        geom.set("rgba" if index == 0 else "group", _GROUND if index == 0 else _HIDDEN)
    _add_view(root, world, scene)
    mesh = surface(scene.field)
    for material in np.unique(mesh.materials).tolist():
        part = mesh.part(mesh.materials == material)
        _add_mesh(assets, world, f"map{material}", (part.vertices, part.triangles), scene.surface_colour(material))
    for robot, model in zip(placed, robots, strict=True):
        bodies = {body.get("name"): body for base in model.bodies for body in base.iter("body")}
        for link, shapes in visuals(robot.robot).items():
            for index, shape in enumerate(shapes):
                name = f"{model.name}/{link}/seen{index}"
                body = bodies[f"{model.name}/{link}"]
                _add_mesh(assets, body, name, (shape.points, shape.corners), shape.colour)


def _part(root: Element, name: str) -> Element:
    part = root.find(name)
    assert part is not None  # noqa: S101  # of every model
    return part


def _add_view(root: Element, world: Element, scene: Scene) -> None:
    """Add light, and the angle of view that pictures have."""
    camera = south_west_of(scene.field.extent)
    wide, high = camera.pixels
    visual = SubElement(root, "visual")
    SubElement(visual, "global", fovy=numbers([degrees(2 * atan(tan(camera.view / 2) * high / wide))]))
    SubElement(visual, "headlight", ambient="0.4 0.4 0.4", diffuse="0.2 0.2 0.2", specular="0 0 0")
    size = 0.75 * np.hypot(*scene.field.extent) + 0.5  # the map, and the robot west of it
    SubElement(root, "statistic", center="0 0 0", extent=numbers([size]))
    sun = {"directional": "true", "pos": numbers((2 * size, -2.5 * size, 4 * size)), "dir": "-0.4 0.5 -0.77"}
    SubElement(world, "light", sun, diffuse="0.6 0.6 0.6", specular="0 0 0", castshadow="true")


def _add_mesh(assets: Element, body: Element, name: str, triangles: tuple[Array, Ints], colour: Colour) -> None:
    """Add triangles as a visual shape, without those that have no area; no shape if none has."""
    points, corners = triangles
    a, b, c = (points[corners[:, corner]] for corner in range(3))
    with_area = corners[np.linalg.norm(np.cross(b - a, c - a), axis=1) > 0]
    if not len(with_area):
        return
    vertices, faces = np.unique(points[with_area].reshape(-1, 3), axis=0, return_inverse=True)
    face = " ".join(map(str, faces.ravel().tolist()))
    SubElement(assets, "mesh", name=name, inertia="shell", vertex=numbers(vertices.ravel()), face=face)
    SubElement(body, "geom", _SEEN, type="mesh", mesh=name, rgba=numbers((*colour, 1.0)))
