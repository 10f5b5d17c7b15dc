"""The body of a robot: its collision shapes as they are seen from below, its mass and what of it is driven.

An included robot is made of links with parts; one of a file is read from its <model> once more. Joints are at rest: a
servo at its angle, all others at 0, as the model has them. Wheels are what hangs on the joints of a drive, tracks the
links that it names; of a model without a drive that is known, whatever hangs on a joint that turns is taken to drive.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator
from functools import lru_cache
from typing import TYPE_CHECKING
from xml.etree.ElementTree import Element, fromstring

import numpy as np

from rsegen.errors import FileError
from rsegen.field.stepfield import Array
from rsegen.robots.links import Box, Cylinder, Link, pose_matrix, posed, turn_about
from rsegen.robots.meshes import collision_mesh, simplified
from rsegen.robots.sdf_shapes import ROUND, ModelFrames, file_and_scale, floats, form_of, inertials, radius_and_length
from rsegen.standing.body import (
    Body,
    CollisionPart,
    Shape,
    SurfaceSamples,
    body_of_shapes,
    sample_distance,
    sampled_ball,
    sampled_box,
    sampled_cylinder,
    sampled_ellipsoid,
    sampled_mesh,
)

if TYPE_CHECKING:  # both have a body, which is made here
    from rsegen.robots.base import Robot
    from rsegen.robots.sdf_file import SdfRobot

_CUBES = 4
"""Cubes along the distance of samples in each of which a mesh of many faces has one point."""

_THIN = 1e-9
"""Least scale of a mesh: with 0 it has no size."""

_GROUND = 1.0
"""Friction of the ground: simulators take the smaller of two, so more of a robot's own has no effect."""


@lru_cache(maxsize=16)
def body_of_links(robot: Robot) -> Body:
    """Return the body of an included robot; ParameterError if it has no collision shapes."""
    distance, joints = sample_distance(robot.size[0]), {joint.name: joint for joint in robot.joints}
    poses = {link.name: posed(link.pose) for link in robot.links}
    for servo in robot.servos:  # which holds what hangs on its joint at an angle
        joint = joints[servo.joint]
        poses[joint.child][:3, :3] @= turn_about(joint.axis or (0, 0, 1), servo.rest)
    driven = robot.drive.links(lambda name: joints[name].child)
    links = [(link, poses[link.name]) for link in robot.links]
    centres = [pose[:3, :3] @ np.array(link.centre[:3]) + pose[:3, 3] for link, pose in links]
    return body_of_shapes(
        _shapes(links, driven, distance),
        mass=robot.mass,
        centre=np.average(centres, axis=0, weights=[link.mass for link in robot.links]),
        speed=robot.driving_speed,
        distance=distance,
        where=robot.kind,
    )


def _shapes(links: Iterable[tuple[Link, Array]], driven: set[str], distance: float) -> Iterator[Shape]:
    """Yield the collision shapes of links at their poses, (4, 4)."""
    for link, pose in links:
        for part in link.parts:
            if part.surface is None:
                continue
            mu, mu2 = (min(mu, _GROUND) for mu in (part.surface.mu, part.surface.mu2))
            if isinstance(part.solid, Box):
                solid = sampled_box(part.solid.size, distance)
            elif isinstance(part.solid, Cylinder):
                solid = sampled_cylinder(part.solid.radius, part.solid.length, distance)
            else:
                solid = sampled_ball(part.solid.radius, distance)
            yield (
                CollisionPart(f"{link.name}::{part.name}", link.name in driven, mu, mu2),
                solid,
                pose @ posed(part.pose),
            )


@lru_cache(maxsize=16)
def body_of_file(robot: SdfRobot) -> Body:
    """Return the body of a robot of a file; ParameterError without collision shapes, FileError for unknown ones."""
    model = fromstring(robot.text)  # noqa: S314  # was found to be plain elements
    frames, distance = ModelFrames(model, robot.kind), sample_distance(robot.size[0])
    read = robot.read_drive
    driven = read.drive.links(frames.child) if read else set(map(frames.child, robot.joints))
    lifted = pose_matrix((0, 0, robot.lift))  # the origin of a robot in a world is below its lowest shape
    shapes: list[Shape] = []
    solids: dict[Hashable, list[tuple[SurfaceSamples, Array]]] = {}
    for link, collision, geometry in frames.collisions():
        name, pose = f"{link}::{collision.get('name', '')}", lifted @ frames.shape(link, collision)
        texts = (collision.findtext(f"surface/friction/ode/{mu}") or "1" for mu in ("mu", "mu2"))  # 1 by default
        mu, mu2 = (min(max(floats(text, 1, frames.where)[0], 0.0), _GROUND) for text in texts)
        part = CollisionPart(name, link in driven, mu, mu2)
        if (form := form_of(geometry)) not in solids:
            solids[form] = list(_solids(geometry[0], distance, frames.where, name))
        shapes += [(part, solid, pose @ at) for solid, at in solids[form]]
    masses = inertials(frames).values()
    centre = np.average([link.centre for link in masses], axis=0, weights=[link.mass for link in masses])
    return body_of_shapes(
        shapes,
        mass=sum(link.mass for link in masses),
        centre=lifted[:3, :3] @ centre + lifted[:3, 3],
        speed=robot.driving_speed,
        distance=distance,
        where=robot.kind,
    )


def _solids(kind: Element, distance: float, where: str, name: str) -> Iterator[tuple[SurfaceSamples, Array]]:
    """Yield the solids of a geometry with their poses in it; a capsule is a cylinder and two balls."""
    if kind.tag == "box":
        yield sampled_box(floats(kind.findtext("size"), 3, where), distance), np.eye(4)
    elif kind.tag == "ellipsoid":
        yield sampled_ellipsoid(floats(kind.findtext("radii"), 3, where), distance), np.eye(4)
    elif kind.tag in ROUND:
        radius, length = radius_and_length(kind, where)
        if kind.tag != "sphere":  # a cone has the cylinder around it: no robot is known that stands on one
            yield sampled_cylinder(radius, length, distance), np.eye(4)
        for end in {"sphere": (0.0,), "capsule": (-length / 2, length / 2)}.get(kind.tag, ()):
            yield sampled_ball(radius, distance), pose_matrix((0, 0, end))
    elif kind.tag == "mesh":
        path, scale = file_and_scale(kind, where)
        side = distance / _CUBES / max(float(np.abs(scale).max()), _THIN)
        points, corners = simplified(collision_mesh(path), side)
        yield sampled_mesh(points * scale, corners, distance), np.eye(4)
    else:
        raise FileError(f"{where}: {name} is a <{kind.tag}>, whose surface is not known")
