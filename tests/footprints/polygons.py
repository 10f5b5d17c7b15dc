"""How much of a cell a turned rectangle covers, by clipping polygons: another way than that of rsegen."""

from __future__ import annotations

from math import cos, sin

import numpy as np

from rsegen.field.stepfield import Array, StepField
from rsegen.footprints import Rectangle

Point = tuple[float, float]


def corners(rectangle: Rectangle, x: float, y: float, yaw: float) -> list[Point]:
    low_x, low_y, high_x, high_y = rectangle
    own = ((low_x, low_y), (high_x, low_y), (high_x, high_y), (low_x, high_y))
    return [(x + cos(yaw) * a - sin(yaw) * b, y + sin(yaw) * a + cos(yaw) * b) for a, b in own]


def clipped(polygon: list[Point], axis: int, limit: float, sign: int) -> list[Point]:
    """The part of a polygon on one side of a line (Sutherland and Hodgman 1974)."""
    found: list[Point] = []
    for one, other in zip(polygon, polygon[1:] + polygon[:1], strict=True):
        here, there = (sign * (limit - point[axis]) for point in (one, other))
        if here >= 0:
            found.append(one)
        if here * there < 0:
            share = here / (here - there)
            found.append((one[0] + share * (other[0] - one[0]), one[1] + share * (other[1] - one[1])))
    return found


def area(polygon: list[Point]) -> float:
    if len(polygon) < 3:
        return 0.0
    return abs(sum(a[0] * b[1] - a[1] * b[0] for a, b in zip(polygon, polygon[1:] + polygon[:1], strict=True))) / 2


def covered(rectangle: Rectangle, x: float, y: float, yaw: float, edges: tuple[Array, Array]) -> Array:
    """The area of each cell under a rectangle at a pose, square metres, shape (n_x, n_y)."""
    found = np.zeros([len(line) - 1 for line in edges])
    polygon = corners(rectangle, x, y, yaw)
    for i, j in np.ndindex(found.shape):
        part = polygon
        for axis, index in ((0, i), (1, j)):
            low, high = float(edges[axis][index]), float(edges[axis][index + 1])
            part = clipped(clipped(part, axis, high, 1), axis, low, -1)
        found[i, j] = area(part)
    return found


def heights_under(field: StepField, rectangle: Rectangle, x: float, y: float, yaw: float) -> Array:
    """The heights of all blocks under a rectangle at a pose; none of it may be outside the field."""
    areas = covered(rectangle, x, y, yaw, field.edges())
    assert abs(areas.sum() - rectangle.length * rectangle.width) < 1e-9
    return np.asarray(field.heights[areas > 1e-9])
