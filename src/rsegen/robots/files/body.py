"""The body of a model of SDF: its collision shapes as they are seen from below, its mass and what of it is driven.

Joints are at 0, as the model has them.
"""

from __future__ import annotations

from collections.abc import Collection, Hashable, Iterator
from xml.etree.ElementTree import Element

import numpy as np

from rsegen.errors import FileError
from rsegen.field.stepfield import Array
from rsegen.geometry.poses import pose_matrix
from rsegen.robots.files.meshes import collision_mesh, simplified
from rsegen.robots.files.sdf_elements import coefficient
from rsegen.robots.files.sdf_shapes import (
    ROUND,
    ModelFrames,
    file_and_scale,
    floats,
    form_of,
    inertials,
    radius_and_length,
)
from rsegen.robots.links import GROUND_FRICTION
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

_CUBES = 4
"""Cubes along the distance of samples in each of which a mesh of many faces has one point."""

_THIN = 1e-9
"""Least scale of a mesh: with 0 it has no size."""


def body_of_model(frames: ModelFrames, driven: Collection[str], *, lift: float, length: float, speed: float) -> Body:
    """Return the body of a model of SDF; ParameterError without collision shapes, FileError for unknown ones.

    driven: the links that drive it; lift: of its origin above the ground, metres; length: of the robot; speed: at which
    it drives over rough ground, m/s
    """
    distance = sample_distance(length)
    lifted = pose_matrix((0, 0, lift))  # the origin of a robot in a world is below its lowest shape
    shapes: list[Shape] = []
    solids: dict[Hashable, list[tuple[SurfaceSamples, Array]]] = {}
    for link, collision, geometry in frames.collisions():
        name, pose = f"{link}::{collision.get('name', '')}", lifted @ frames.shape(link, collision)
        mu, mu2 = (min(coefficient(collision, tag, frames.where), GROUND_FRICTION) for tag in ("mu", "mu2"))
        part = CollisionPart(name, link in driven, mu, mu2)
        if (form := form_of(geometry)) not in solids:
            solids[form] = list(_solids(geometry[0], distance, frames.where, name))
        shapes += [(part, solid, pose @ at) for solid, at in solids[form]]
    # Centres of mass are in the model's frame, samples in the frame that has its origin on the ground.
    masses = inertials(frames).values()
    centre = np.average([link.centre for link in masses], axis=0, weights=[link.mass for link in masses])
    return body_of_shapes(
        shapes,
        mass=sum(link.mass for link in masses),
        centre=lifted[:3, :3] @ centre + lifted[:3, 3],
        speed=speed,
        distance=distance,
        where=frames.where,
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
        # In units of the file, whose points are scaled afterwards.
        side = distance / _CUBES / max(float(np.abs(scale).max()), _THIN)
        points, corners = simplified(collision_mesh(path), side)
        yield sampled_mesh(points * scale, corners, distance), np.eye(4)
    else:
        raise FileError(f"{where}: {name} is a <{kind.tag}>, whose surface is not known")
