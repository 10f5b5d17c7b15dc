"""The ground that a robot can reach on a map, for the plan and for the 3D view, and the shape of the robot."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from rsegen.exporters.scene import Scene
from rsegen.field.stepfield import Array, Mask, StepField
from rsegen.gui.model.solid import Bounds, Floats, Lines, Solid, solid
from rsegen.standing.draping import draped
from rsegen.standing.spots import Outline, Spot

EASTWARD, NORTHWARD = (255, 45, 149), (255, 140, 0)
"""The colours of ways from west to east, and from south to north."""


class Way(NamedTuple):
    """A way across: points (n, 2) [m], from one side to the other; whether it is from west to east; whether it is one
    that the robot cannot drive to its end.
    """

    points: Array
    is_eastward: bool
    is_too_steep: bool = False


class Reach(NamedTuple):
    """What a robot can do on a map.

    text: whether it crosses; region: (n_x, n_y), the blocks below it in the largest area, in which it can drive from
    every place to every other
    spots: the first for a start and the second for a goal, of a robot that covers `outline`; maybe none
    """

    text: str
    region: Mask
    ways: tuple[Way, ...]
    spots: tuple[Spot, ...]
    outline: Outline


def corners(outline: Outline, spot: Spot) -> Array:
    """The corners (4, 2) of a robot at a spot, the two in front last [m]."""
    return np.roll(outline.at(spot), 1, axis=0)


_PALE, _WHITE = (245, 245, 245), (255, 255, 255)
"""Blocks that the robot does not reach are nearly white."""

_DASH = 0.5
"""The length of a dash, and of the gap after it, in widths of a block."""

_DISC, _DISC_OF_MAP = 0.35, 0.012
"""The radius of the ends of ways: in widths of a block, and as a share of the map's longer side, whichever is more."""

_QUARTERS = 8
"""The faces of a disc."""


class SpotShape(NamedTuple):
    """A spot: outline (4, 3), front (2, 3) and middle (3,) of a robot on it [m], and its letter."""

    outline: Array
    front: Array
    middle: Array
    name: str


class WayShape(NamedTuple):
    """A way across on the blocks.

    lines: in dashes if it is too steep; ends: discs at both; hole: a white disc that makes a ring of the first
    """

    lines: Lines
    is_eastward: bool
    ends: Solid
    hole: Solid


class ReachShape(NamedTuple):
    """veil: the surface of the blocks that the robot does not reach, all in one colour."""

    veil: Solid
    ways: tuple[WayShape, ...]
    spots: tuple[SpotShape, ...]


def reach_shape(scene: Scene, reach: Reach) -> ReachShape:
    """What a robot can do on the map of a scene, which has the cells of its region."""
    field = scene.field
    return ReachShape(
        veil=_veil(scene, ~reach.region & ~field.frame),
        ways=tuple(_way(field, way) for way in reach.ways),
        spots=tuple(
            _spot(field, corners(reach.outline, spot), spot.z, name)
            for name, spot in zip(("S", "G"), reach.spots, strict=False)
        ),
    )


def dashes(points: Array, length: float) -> Lines:
    """Every second part, of this length, of a line through points (n, 3)."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    cuts = np.unique(np.concatenate([along, np.arange(0, along[-1], length)]))
    kept = (cuts[:-1] + cuts[1:]) / 2 // length % 2 == 0
    ends = np.stack([cuts[:-1][kept], cuts[1:][kept]], axis=1).ravel()
    at = np.column_stack([np.interp(ends, along, points[:, axis]) for axis in range(3)])
    return Lines(at, np.arange(len(at)).reshape(-1, 2))


def _veil(scene: Scene, hidden: Mask) -> Solid:
    """The surface of the hidden cells alone; those on the ground are flat faces there."""
    field = scene.field
    shown = replace(field, levels=np.where(hidden, field.levels, np.int16(0)), frame=np.zeros_like(field.frame))
    made, ground = solid(replace(scene, field=shown)), _tiles(field, hidden & (field.levels == 0))
    points = np.concatenate([made.points, ground])
    return coloured(points, _PALE)


def coloured(points: Floats, colour: tuple[int, int, int]) -> Solid:
    """Faces of four points each (4 n, 3), in one colour."""
    faces = np.arange(len(points), dtype=np.int32).reshape(-1, 4)
    colours = np.tile(np.array(colour, dtype=np.uint8), (len(faces), 1))
    return Solid(points, faces, colours, np.zeros_like(points[:, :2]))


def _tiles(field: StepField, cells: Mask) -> Floats:
    """The corners (4 n, 3) of cells on the ground."""
    edges_x, edges_y = field.edges()
    i, j = np.nonzero(cells)
    x, y = edges_x[np.stack([i, i + 1, i + 1, i], axis=1)], edges_y[np.stack([j, j, j + 1, j + 1], axis=1)]
    return np.stack([x, y, np.zeros_like(x)], axis=2).reshape(-1, 3).astype(np.float32)


def _way(field: StepField, way: Way) -> WayShape:
    points = draped(field, way.points)
    pairs = np.arange(len(points) - 1)[:, None] + (0, 1)
    lines = dashes(points, _DASH * field.block_width) if way.is_too_steep else Lines(points, pairs)
    radius = max(_DISC * field.block_width, _DISC_OF_MAP * max(field.extent))
    colour = EASTWARD if way.is_eastward else NORTHWARD
    ends, hole = _discs(points[[0, -1]], radius, colour), _discs(points[:1], 0.6 * radius, _WHITE)
    return WayShape(lines, way.is_eastward, ends, hole)


def _discs(middles: Array, radius: float, colour: tuple[int, int, int]) -> Solid:
    """Flat discs around points (n, 3)."""
    angles = np.linspace(0, 2 * np.pi, 2 * _QUARTERS + 1)
    ring = radius * np.column_stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)])
    parts = np.stack([np.zeros_like(ring[:-1:2]), ring[:-1:2], ring[1::2], ring[2::2]], axis=1)
    points = (middles[:, None, None] + parts).reshape(-1, 3).astype(np.float32)
    return coloured(points, colour)


def _spot(field: StepField, outline: Array, ground: float, name: str) -> SpotShape:
    """A place for a robot, as high as the highest block that it covers."""
    edges = field.edges()
    low, high = (
        [int(np.searchsorted(edges[axis], value)) for axis, value in enumerate(each)]
        for each in (outline.min(axis=0), outline.max(axis=0))
    )
    covered = field.heights[tuple(slice(max(start - 1, 0), stop) for start, stop in zip(low, high, strict=True))]
    top = np.full((4, 1), max(ground, float(covered.max(initial=0.0))))
    raised = np.hstack([outline, top])
    return SpotShape(raised, raised[2:], raised.mean(axis=0), name)


class RobotPart(NamedTuple):
    """A solid of a robot: the sides of a box, radius and length of a cylinder, or the radius of a sphere [m].

    pose: (4, 4), from the solid's frame, its centre in the origin and a cylinder along z, to that of the robot, whose
    origin is on the ground; colour: 0..1
    """

    sizes: tuple[float, ...]
    pose: Array
    colour: tuple[float, float, float]


class RobotShape(NamedTuple):
    """The parts of a robot, and its overall length, width and height [m]."""

    parts: tuple[RobotPart, ...]
    size: tuple[float, float, float]


def place_next_to(found: Bounds, rim: float, shape: RobotShape) -> tuple[float, float]:
    """Where a robot stands on the ground, south-east of a map, where neither blocks nor the axes' numbers hide it."""
    _, east, south, *_ = found
    length, width, _ = shape.size
    return east + rim / 2 + length / 2, south - rim / 2 - width / 2
