"""Spots of robots, and outlines of robots seen from above: rectangles apart from each other, and within a field."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import NamedTuple

import numpy as np

from rsegen.field.stepfield import Array, Mask, StepField
from rsegen.standing.body import Body

SPOT_HEADINGS = 16
"""Headings at the centres, edges and corners of cells, evenly spread: 22.5 degrees apart."""

EXACT = 1e-9
"""Metres of rounding errors by which an outline may be beyond the map."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Spot:
    """A place for a start or a goal of a robot.

    Attributes
    ----------
    x, y, z, roll, pitch, yaw : float
        Pose of the robot's origin at rest, metres and radians, as in Gazebo.
    tilt : float
        Angle between its upright and the vertical, radians.
    tip_angle : float
        The least turn that tips it over, radians.
    reason : str
        Empty; at a place that was taken for want of a spot, why it is none.
    """

    x: float
    y: float
    z: float
    yaw: float
    roll: float = 0.0
    pitch: float = 0.0
    tilt: float = 0.0
    tip_angle: float = 0.0
    reason: str = ""


class Outline(NamedTuple):
    """The smallest rectangle around a robot that heads along x, seen from above, in its own frame, metres."""

    low_x: float
    low_y: float
    high_x: float
    high_y: float

    @classmethod
    def of(cls, body: Body) -> Outline:
        """Return the outline of a body."""
        (low_x, low_y, _), (high_x, high_y, _) = body.low.tolist(), body.high.tolist()
        return cls(low_x, low_y, high_x, high_y)

    @property
    def length(self) -> float:
        """Side along x."""
        return self.high_x - self.low_x

    @property
    def width(self) -> float:
        """Side along y."""
        return self.high_y - self.low_y

    @property
    def middle(self) -> tuple[float, float]:
        """Centre of the rectangle."""
        return (self.low_x + self.high_x) / 2, (self.low_y + self.high_y) / 2

    def corners(self, x: Array, y: Array, yaw: Array) -> Array:
        """Return the corners of robots at poses, shape (n, 4, 2), counterclockwise from the rear right one."""
        own_x = np.array([self.low_x, self.high_x, self.high_x, self.low_x])
        own_y = np.array([self.low_y, self.low_y, self.high_y, self.high_y])
        c, s = np.cos(yaw)[:, None], np.sin(yaw)[:, None]
        return np.stack([x[:, None] + c * own_x - s * own_y, y[:, None] + s * own_x + c * own_y], axis=-1)

    def at(self, spot: Spot) -> Array:
        """Return its corners at a spot, shape (4, 2)."""
        return np.asarray(self.corners(*(np.array([value]) for value in (spot.x, spot.y, spot.yaw)))[0])


def apart(outline: Outline, gap: float, x: Array, y: Array, yaw: Array, spot: Spot) -> Mask:
    """Return whether a robot at each x, y, yaw is at least `gap` metres away from a robot at a spot, along some axis.

    Two rectangles are apart exactly if their projections on a side of one of them are (Gottschalk, Lin and Manocha
    1996).
    """
    first = outline.at(spot)[None]
    others = outline.corners(x, y, yaw)
    separated = np.zeros(len(x), dtype=bool)
    for axis in (np.full(len(x), spot.yaw), np.full(len(x), spot.yaw + pi / 2), yaw, yaw + pi / 2):
        normal = np.stack([np.cos(axis), np.sin(axis)], axis=-1)[:, None, :]
        own, theirs = (first * normal).sum(axis=-1), (others * normal).sum(axis=-1)
        between = np.maximum(own.min(axis=1) - theirs.max(axis=1), theirs.min(axis=1) - own.max(axis=1))
        separated |= between >= gap - EXACT
    return separated


def fits(field: StepField, body: Body) -> bool:
    """Return whether a robot is wholly within a field at one of the 16 headings, however uneven it is there."""
    yaw = np.arange(SPOT_HEADINGS) * 2 * pi / SPOT_HEADINGS
    room = range_inside(field.extent, Outline.of(body), yaw)
    return bool((room[:, 0] <= room[:, 1]).all(axis=0).any())


def range_inside(extent: tuple[float, float], outline: Outline, yaw: Array) -> Array:
    """Return the least and largest x and y of a robot that is wholly within a field, metres, (2, 2, n).

    The first axis is x and y, the second least and largest, the third the heading; extent: sides of the field, metres.
    """
    c, s, (middle_x, middle_y) = np.cos(yaw), np.sin(yaw), outline.middle
    middles = middle_x * c - middle_y * s, middle_x * s + middle_y * c
    half_x, half_y = outline.length / 2, outline.width / 2
    halves = half_x * np.abs(c) + half_y * np.abs(s), half_x * np.abs(s) + half_y * np.abs(c)
    sides = zip(middles, halves, extent, strict=True)
    return np.stack([(-side / 2 - EXACT - at + half, side / 2 + EXACT - at - half) for at, half, side in sides])
