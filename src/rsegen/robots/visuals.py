"""The shapes of a robot as coloured triangles, link by link: for pictures and for windows of MuJoCo.

They are read from its SDF <model>, for rsegen's robots and robots of files alike. Round shapes have 16 sides.
In a picture of a drive, a link that has no visuals, or one that cannot be read, has its collision shapes.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from contextlib import suppress
from typing import Literal, NamedTuple, TypeAlias
from xml.etree.ElementTree import Element, fromstring

import numpy as np

from rsegen.errors import UserError
from rsegen.field.stepfield import Array, Ints
from rsegen.pictures.camera import Triangles
from rsegen.robots.files.meshes import read_mesh, simplified_to
from rsegen.robots.files.sdf_file import SdfRobot
from rsegen.robots.files.sdf_shapes import (
    ROUND,
    ModelFrames,
    file_and_scale,
    floats,
    form_of,
    geometries,
    radius_and_length,
)
from rsegen.robots.links import DARK, GREY
from rsegen.robots.lookup import DrivableRobot
from rsegen.scene.colours import Colour

_SIDES = 16
"""Sides of what is round."""

_RINGS = 7
"""Rings of a sphere from pole to pole: an odd number, so that the middle of a capsule is straight."""

_FINEST = 200
"""Points along the diagonal of a mesh of many faces: in the picture of a robot some three pixels apart."""


class Visual(NamedTuple):
    """A shape of a link: points (n, 3), metres, in the frame of the link; corners (m, 3), indices of points."""

    points: Array
    corners: Ints
    colour: Colour

    @property
    def triangles(self) -> Triangles:
        """Triangles of the visual in its colour."""
        return Triangles(self.points[self.corners], np.tile(self.colour, (len(self.corners), 1)))


def visuals(robot: DrivableRobot) -> Mapping[str, list[Visual]]:
    """Return the visual shapes of each link of a robot, by the link's name."""
    frames, driven = _frames_and_driven(robot)
    shapes: dict[str, list[Visual]] = {}
    known: Known = {}
    for link, element in frames.links():
        default = DARK if link in driven else GREY
        shapes[link] = []
        for tag in ("visual", "collision"):  # the second if nothing of the first can be drawn
            with suppress(UserError, ImportError):  # such as a mesh that is not here
                every = [
                    _shape(frames, link, shape, geometry, default, known)
                    for shape, geometry in geometries(element, tag)
                ]
                shapes[link] = shapes[link] or every
    return shapes


class PlacedShapes(NamedTuple):
    """Shapes in the frame of a robot whose lowest collision shape is on the ground, and why others are not among them.

    not_drawn: why, with the names of the links; as many as there are files or kinds of shapes that cannot be read
    """

    shapes: list[Visual]
    not_drawn: Mapping[str, list[str]]


Known: TypeAlias = dict[Hashable, tuple[Array, Ints]]
"""Points and triangles of geometries that have been read, by their forms."""


def placed_shapes(
    robot: DrivableRobot, tag: Literal["visual", "collision"], known: Known | None = None
) -> PlacedShapes:
    """Return the visual or the collision shapes of a robot, with its joints as its model has them.

    known: geometries that are not read again; those that are read are added
    """
    known = {} if known is None else known
    frames, driven = _frames_and_driven(robot)
    shapes: list[Visual] = []
    not_drawn: dict[str, list[str]] = {}
    for link, element in frames.links():
        pose, default = frames.transform(link), DARK if link in driven else GREY
        for shape, geometry in geometries(element, tag):
            uri = (geometry[0].findtext("uri") or "").strip()
            try:
                points, corners, colour = _shape(frames, link, shape, geometry, default, known)
            except UserError as error:
                is_nowhere = "://" in uri and not uri.startswith("file://")  # it has no path (`resolve_uris`)
                not_drawn.setdefault(f"{uri} is not found" if is_nowhere else str(error), []).append(link)
            except ImportError:
                not_drawn.setdefault(f"{uri} is read by trimesh, which is not installed", []).append(link)
            else:
                if not len(corners):
                    not_drawn.setdefault(f"a <{geometry[0].tag}> is not drawn", []).append(link)
                placed = points @ pose[:3, :3].T + pose[:3, 3] + (0.0, 0.0, robot.lift)
                shapes.append(Visual(placed, corners, colour))
    return PlacedShapes(shapes, not_drawn)


def _frames_and_driven(robot: DrivableRobot) -> tuple[ModelFrames, set[str]]:
    """Return the model of a robot without its plug-ins, and the links on which it drives, none if it has no drive."""
    frames = ModelFrames(fromstring(robot.without_plugins("robot")), robot.kind)  # noqa: S314  # ours, or found plain
    if isinstance(robot, SdfRobot) and not robot.read_drive:
        return frames, set()
    return frames, robot.drive.links(frames.child)


def _shape(frames: ModelFrames, link: str, shape: Element, geometry: Element, default: Colour, known: Known) -> Visual:
    """Return a shape in the frame of its link."""
    if (form := form_of(geometry)) not in known:
        known[form] = _triangles(geometry[0], frames.where)
    points, corners = known[form]
    pose = np.linalg.inv(frames.transform(link)) @ frames.shape(link, shape)
    return Visual(points @ pose[:3, :3].T + pose[:3, 3], corners, colour_of(shape, frames.where) or default)


def colour_of(shape: Element, where: str) -> Colour | None:
    """Return the colour of a shape, parts from 0 to 1; None if it has none."""
    words = (shape.findtext("material/diffuse") or shape.findtext("material/ambient") or "").split()[:3]
    if not words:
        return None
    red, green, blue = np.clip(floats(" ".join(words), 3, where), 0, 1).tolist()
    return red, green, blue


def _triangles(kind: Element, where: str) -> tuple[Array, Ints]:
    """Return points and triangles of a geometry of SDF, in its own frame; none of an unknown one."""
    if kind.tag == "mesh":
        path, scale = file_and_scale(kind, where)
        points, corners = simplified_to(read_mesh(path), _FINEST)
        return points * scale, corners
    if kind.tag == "box":
        return _CUBE * floats(kind.findtext("size"), 3, where), _CUBE_CORNERS
    if kind.tag == "ellipsoid":
        return _turned(_ROUND) * floats(kind.findtext("radii"), 3, where), _turned_corners(len(_ROUND))
    if kind.tag in ROUND:
        radius, length = radius_and_length(kind, where)
        half = length / 2
        # The outline goes from the lower pole to the upper one; a capsule is a sphere whose halves are moved apart.
        if kind.tag in ("sphere", "capsule"):
            outline = _ROUND * radius + np.column_stack([np.zeros(len(_ROUND)), np.sign(_ROUND[:, 1]) * half])
        elif kind.tag == "cylinder":
            outline = np.array([(0, -half), (radius, -half), (radius, half), (0, half)])
        else:
            outline = np.array([(0, -half), (radius, -half), (0, half)])
        return _turned(outline), _turned_corners(len(outline))
    return np.empty((0, 3)), np.empty((0, 3), dtype=np.int64)


_CUBE = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
_CUBE_FACES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
_CUBE_CORNERS: Ints = np.array(_CUBE_FACES)[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
"""A cube of side 1, and its faces, counterclockwise seen from outside."""

_ANGLES = (np.arange(_RINGS + 1) / _RINGS - 0.5) * np.pi
_ROUND = np.column_stack([np.cos(_ANGLES), np.sin(_ANGLES)]).round(12)
"""The outline of a sphere of radius 1: distance from the axis, and height, from the lower to the upper pole."""


def _turned(outline: Array) -> Array:
    """Return the points of a solid of revolution about z, from distances from the axis and heights, (n, 2)."""
    angles = np.arange(_SIDES) / _SIDES * 2 * np.pi
    x, y = (outline[:, :1] * turn(angles) for turn in (np.cos, np.sin))
    return np.stack([x, y, np.broadcast_to(outline[:, 1:], x.shape)], axis=-1).reshape(-1, 3)


def _turned_corners(rings: int) -> Ints:
    """Return the triangles between the rings of such a solid, counterclockwise seen from outside."""
    # Point `side` of a ring has the number ring * _SIDES + side; between four of them are two triangles.
    ring, side = (grid.ravel() for grid in np.meshgrid(np.arange(rings - 1), np.arange(_SIDES), indexing="ij"))
    low, low_next = ring * _SIDES + side, ring * _SIDES + (side + 1) % _SIDES
    high, high_next = low + _SIDES, low_next + _SIDES
    return np.concatenate([np.stack([low, low_next, high_next], 1), np.stack([low, high_next, high], 1)])
