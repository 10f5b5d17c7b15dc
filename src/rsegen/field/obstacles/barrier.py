"""The profile of both barriers: a ridge along a segment that slopes down on all sides."""

from __future__ import annotations

import numpy as np

from rsegen.field.obstacles.base import Grid, Shaped
from rsegen.field.stepfield import Array
from rsegen.params.places import Cell


class Barrier(Shaped):
    """f = 1 within half a cell of the segment first..last, then falls to 0 over w = (softness / 100) * L cells."""

    __slots__ = ()

    def run_out(self, grid: Grid) -> float:
        """Width w of the slopes in cells; softness is relative to the chunk size."""
        return self.softness / 100 * grid.chunk_size

    def reach(self, grid: Grid) -> float:
        """The profile is 0 beyond w + 1/2 cells."""
        return self.run_out(grid) + 0.5

    def profile(self, x: Array, y: Array, first: Cell, last: Cell, grid: Grid) -> Array:
        """1 - (d - 1/2) / w on the slopes, d the distance from the axis; vertical walls if w = 0."""
        beyond = _distance_to_segment(x, y, first, last) - 0.5
        w = self.run_out(grid)
        slope = np.maximum(0.0, 1 - beyond / w) if w else 0.0
        return np.where(beyond <= 0, 1.0, slope)


def _distance_to_segment(x: Array, y: Array, first: Cell, last: Cell) -> Array:
    (x1, y1), (x2, y2) = first, last
    along_x, along_y = x2 - x1, y2 - y1
    squared = along_x**2 + along_y**2
    t = ((x - x1) * along_x + (y - y1) * along_y) / squared if squared else np.zeros((1, 1))
    t = np.clip(t, 0, 1)
    return np.sqrt((x - x1 - t * along_x) ** 2 + (y - y1 - t * along_y) ** 2)
