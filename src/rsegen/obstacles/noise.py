"""Noise: uneven ground without walls, of random heights at points some blocks apart and straight lines between them.

    h(x, y) = bilinear interpolation of u, one random number for each point, s blocks apart
    level = n h, rounded down, with n levels

A spacing s of 1 is uniform random blocks; the wider it is, the longer are the hills. The first point is the first cell,
the last one is on the last cell or beyond. The cost is some twenty operations per cell. Trainers of legged robots have
the same terrain in metres (`noise_range`, `downsampled_scale`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from rsegen.field.stepfield import Array, Levels, Mask
from rsegen.obstacles.base import Layout, register
from rsegen.params.sorts import Cell, Integer


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Noise(Layout):
    """Random hills: heights drawn some blocks apart, and even slopes between them."""

    kind: ClassVar[str] = "noise"
    also: ClassVar[tuple[str, ...]] = ("rough", "uneven", "random_uniform", "hills")

    spacing: Annotated[
        int, Integer(1, 1000, unit="blocks", usual=(1, 10), help="distance of the points whose heights are drawn")
    ] = 4

    def draws(self, shape: Cell) -> Cell:
        """Return the number of points along each axis."""
        return -(-(shape[0] - 1) // self.spacing) + 1, -(-(shape[1] - 1) // self.spacing) + 1

    def laid_out(self, shape: Cell, drawn: Array) -> tuple[Levels, Mask]:
        """Return the level of each cell; all cells are covered."""
        along_y = self._between(drawn, shape[1])
        heights = np.swapaxes(self._between(np.swapaxes(along_y, -1, -2), shape[0]), -1, -2)
        return np.floor(self.levels * heights).astype(np.int16), np.ones(shape, dtype=bool)

    def _between(self, points: Array, cells: int) -> Array:
        """Return the heights of cells along the last axis, interpolated between points."""
        point, within = np.divmod(np.arange(cells), self.spacing)
        further = np.minimum(point + 1, points.shape[-1] - 1)
        lower = points[..., point]
        return np.asarray(lower + (points[..., further] - lower) * (within / self.spacing))
