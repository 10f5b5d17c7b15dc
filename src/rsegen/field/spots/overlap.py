"""Which cells a turned rectangle overlaps, by the separating axis test."""

from __future__ import annotations

from math import ceil, cos, hypot, sin

import numpy as np

from rsegen.field.spots.footprint import Rectangle
from rsegen.field.stepfield import Array, Mask

_TOUCH = 1e-9
"""Metres of overlap up to which a rectangle and a cell only touch."""


def reach(rectangle: Rectangle, width: float) -> int:
    """The number of cells of this width in each direction that the rectangle can overlap, however it is turned."""
    far = hypot(max(-rectangle.low_x, rectangle.high_x), max(-rectangle.low_y, rectangle.high_y))
    return ceil(far / width) + 1


def overlapped(rectangle: Rectangle, yaw: float, at: tuple[float, float], cells: int, width: float) -> Mask:
    """Whether each of (2 cells + 1)^2 cells around the cell (0..width)^2 overlaps a rectangle, turned by yaw, at `at`.

    Two convex shapes are apart exactly if their projections on the normal of one of their sides are.
    """
    middle = (np.arange(-cells, cells + 1) + 0.5) * width
    c, s = cos(yaw), sin(yaw)
    x, y = rectangle.middle
    away_x, away_y = middle[:, None] - (at[0] + c * x - s * y), middle[None, :] - (at[1] + s * x + c * y)
    half, (half_x, half_y) = width / 2, (rectangle.length / 2, rectangle.width / 2)
    tilted = half * (abs(c) + abs(s))
    return np.asarray(
        (np.abs(away_x) < half + half_x * abs(c) + half_y * abs(s) - _TOUCH)
        & (np.abs(away_y) < half + half_x * abs(s) + half_y * abs(c) - _TOUCH)
        & (np.abs(c * away_x + s * away_y) < half_x + tilted - _TOUCH)
        & (np.abs(c * away_y - s * away_x) < half_y + tilted - _TOUCH)
    )


def apart(rectangle: Rectangle, gap: float, one: tuple[float, float, float], x: Array, y: Array, yaw: Array) -> Mask:
    """Whether the rectangle at each x, y, yaw is at least `gap` away from the one at pose `one`, along some axis."""
    half = np.array([rectangle.length / 2, rectangle.width / 2])
    first = _centres(rectangle, *(np.array([value]) for value in one))
    away = _centres(rectangle, x, y, yaw) - first
    separated = np.zeros(len(x), dtype=bool)
    for axis in (np.full(len(x), one[2]), np.full(len(x), one[2] + np.pi / 2), yaw, yaw + np.pi / 2):
        normal = np.stack([np.cos(axis), np.sin(axis)], axis=-1)
        distance = np.abs((away * normal).sum(axis=-1))
        spans = (_span(half, other - axis) for other in (np.full(len(x), one[2]), yaw))
        separated |= distance >= sum(spans) + gap
    return separated


def _centres(rectangle: Rectangle, x: Array, y: Array, yaw: Array) -> Array:
    """The centres of the rectangle at poses, shape (n, 2)."""
    along, across = rectangle.middle
    c, s = np.cos(yaw), np.sin(yaw)
    return np.stack([x + c * along - s * across, y + s * along + c * across], axis=-1)


def _span(half: Array, turned: Array) -> Array:
    """Half of the projection of a rectangle, turned by an angle against the axis."""
    return np.asarray(half[0] * np.abs(np.cos(turned)) + half[1] * np.abs(np.sin(turned)))
