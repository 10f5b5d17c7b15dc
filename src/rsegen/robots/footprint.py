"""The footprint of a robot: the rectangles that the parts of its links cover from below, and how level it has to stand.

Each part becomes axis-aligned rectangles with the height of its underside: a box or an upright cylinder one, a round
part a few, of rising heights, as it widens upwards. A rectangle above a lower one that covers it is left out. Cost: the
pairs of parts, once per robot. A part that is turned about z gets its bounding rectangle, which is too large.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from math import inf, sqrt, tan

import numpy as np

from rsegen.field.stepfield import Array
from rsegen.footprints import Footprint, Rectangle, Underside
from rsegen.footprints.footprint import TILT, TOUCHING
from rsegen.robots import robot_of
from rsegen.robots.base import DrivableRobot, Robot
from rsegen.robots.links import Box, Cylinder, Part, SdfPose, rotation

_RISES = (0.001, 0.005, 0.02, inf)
"""Heights, metres, above the lowest point of a round part at which its width makes a rectangle.

Closer together near the ground, where a circle widens quickly; more of them cost time in every search for spots.
"""

_EXACT = 1e-9
"""Rounding error up to which an axis counts as vertical."""


def footprint_of(robot: DrivableRobot) -> Footprint:
    """Return the footprint of a robot: every part of every link; of one from a file, the rectangle of its size."""
    if isinstance(robot, Robot):
        return _of_links(robot)
    length, width, _ = robot.size
    return Footprint.of_size(length, width)


@lru_cache(maxsize=16)
def _of_links(robot: Robot) -> Footprint:
    parts = _needed([side for link in robot.links for part in link.parts for side in _undersides(part, link.pose)])
    # Supports are the parts on the ground: their distance decides how uneven the ground may be for a tilt.
    middles = np.array([rectangle.middle for rectangle, bottom in parts if bottom <= TOUCHING])
    apart = np.ptp(middles, axis=0).min() if len(middles) else min(robot.size[:2]) / 2
    return Footprint(undersides=parts, limit=tan(TILT) * float(apart), climb=robot.climbs)


def _needed(parts: Sequence[Underside]) -> tuple[Underside, ...]:
    """Return the parts that are not wholly above a lower one, or another one of the same height."""
    kept: list[Underside] = []
    for part in sorted(set(parts), key=lambda part: (part.bottom, -part.rectangle.length, -part.rectangle.width)):
        if not any(other.rectangle.covers(part.rectangle) for other in kept):
            kept.append(part)
    return tuple(kept)


def _undersides(part: Part, link: SdfPose) -> Iterator[Underside]:
    """Yield a part of a link in the frame of the model, as rectangles from the lowest on."""
    of_link = rotation(*link[3:])
    turned, at = of_link @ rotation(*part.pose[3:]), np.array(link[:3]) + of_link @ np.array(part.pose[:3])
    half = _half(part, turned)
    low, solid = at[2] - half[2], part.solid
    flat = isinstance(solid, Box) or (isinstance(solid, Cylinder) and abs(turned[2, 2]) > 1 - _EXACT)
    for begin, end in ((0.0, inf),) if flat else zip((0.0, *_RISES), _RISES, strict=False):
        x, y = (_chord(radius, end) if not flat and radius == half[2] else radius for radius in half[:2].tolist())
        if begin < 2 * half[2]:
            middle = at[0] - x, at[1] - y, at[0] + x, at[1] + y
            yield Underside(Rectangle(*(float(edge) for edge in middle)), round(float(low + begin), 9))


def _half(part: Part, turned: Array) -> Array:
    """Half of the sides of the box around a part, along the axes."""
    solid = part.solid
    if isinstance(solid, Box):
        return np.asarray(np.round(np.abs(turned) @ np.array(solid.size) / 2, 9))
    if isinstance(solid, Cylinder):
        along = np.abs(turned[:, 2])
        across = solid.radius * np.sqrt(np.maximum(1 - along**2, 0))
        return np.asarray(np.round(along * solid.length / 2 + across, 9))
    return np.full(3, solid.radius)


def _chord(radius: float, rise: float) -> float:
    """Half of the width of a circle at a height above its lowest point."""
    return radius if rise >= radius else sqrt(rise * (2 * radius - rise))


def spot_footprint(
    robot: str | os.PathLike[str] | DrivableRobot, size: Sequence[float] | None, max_difference_cm: float | None
) -> Footprint:
    """Return the footprint of a robot, or of a rectangle of this length and width [m] in its place."""
    if size is not None:
        length, width = size
        footprint = Footprint.of_size(length, width)
    else:
        footprint = footprint_of(robot_of(robot))
    if max_difference_cm is None:
        return footprint
    return replace(footprint, most=max_difference_cm / 100)
