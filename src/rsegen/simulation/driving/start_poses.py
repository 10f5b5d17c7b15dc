"""Start poses of robots, next to a map or on top of it, never inside a block."""

from __future__ import annotations

from math import ceil, hypot, pi

import numpy as np

from rsegen.errors import ParameterError
from rsegen.field.stepfield import Array, StepField
from rsegen.params.streams import randint
from rsegen.simulation.simulators.live_world import Pose

GAP = 0.1
"""Metres between a robot and the map next to it, and between two robots."""

DROP_HEIGHT = 0.005
"""Metres above the ground at which robots start, so that they do not start inside it."""


def adjacent_pose(field: StepField, size: tuple[float, float, float], aside: float = 0.0) -> Pose:
    """The pose on the ground west of the map, heading east, `aside` metres north of its centre line."""
    return Pose(x=-field.extent[0] / 2 - GAP - size[0] / 2, y=aside, z=DROP_HEIGHT)


def fits_on_map(field: StepField, size: tuple[float, float, float]) -> bool:
    """Whether a robot of a length, width and height can turn about on the map."""
    return min(field.shape) >= 2 * ceil(hypot(*size[:2]) / 2 / field.block_width) + 1


def poses_on_map(field: StepField, sizes: list[tuple[float, float, float]], rng: np.random.Generator) -> list[Pose]:
    """A random pose for each robot of a length, width and height.

    The ground under each is as even as possible for all its headings; it starts above the highest block there.
    """
    taken: list[tuple[float, float, float]] = []
    return [_spot(field, hypot(length, width) / 2, taken, rng) for length, width, _ in sizes]


def _spot(field: StepField, reach: float, taken: list[tuple[float, float, float]], rng: np.random.Generator) -> Pose:
    """A pose for a robot with this radius, which is added to `taken` as x, y and radius."""
    top, uneven = _ground(field, ceil(reach / field.block_width))
    x, y = (np.arange(n) * field.block_width - (n - 1) * field.block_width / 2 for n in top.shape)
    free = np.ones(top.shape, dtype=bool)
    for other_x, other_y, other in taken:
        free &= np.hypot(x[:, None] - other_x, y[None, :] - other_y) > reach + other + GAP
    if not free.any():
        raise ParameterError("robots", f"not enough room on {field.shape[0]} x {field.shape[1]} cells; give fewer")
    best = np.argwhere(free & (uneven == uneven[free].min()))
    i, j = best[randint(rng, 0, len(best) - 1)]
    taken.append((float(x[i]), float(y[j]), reach))
    return Pose(x=float(x[i]), y=float(y[j]), z=float(top[i, j]) + DROP_HEIGHT, yaw=2 * pi * rng.random())


def _ground(field: StepField, cells: int) -> tuple[Array, Array]:
    """The highest block under a robot on each cell that has so many map cells around it, and how much lower the lowest
    is.
    """
    window = 2 * cells + 1
    if min(field.shape) < window:
        n_x, n_y = field.shape
        raise ParameterError(
            "robot", f"it is too large to start on {n_x} x {n_y} cells; give a smaller robot or a larger map"
        )
    highest, lowest = (_filtered(sign * field.heights, window) * sign for sign in (1, -1))
    return highest, highest - lowest


def _filtered(heights: Array, window: int) -> Array:
    """The maximum over a square window, where it lies within."""
    for axis in (0, 1):
        heights = np.lib.stride_tricks.sliding_window_view(heights, window, axis=axis).max(axis=-1)
    return np.asarray(heights)
