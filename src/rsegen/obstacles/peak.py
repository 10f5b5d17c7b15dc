"""The peak of the paper's figure 3: a table with vertical sides, a frustum, or a cone, by its softness.

    f = clip((R - d) / w, 0, 1),  w = (softness / 100) * (R - d0)

d is the distance from the centre, scaled so that the ellipse in a rectangle is a circle of radius R, half the shorter
side; d0 is the least d of any cell, which is above 0 if the centre lies between cells. Without it a cone of an even
number of cells would not reach its highest level. The cost is a few operations per cell of the rectangle.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from rsegen.field.stepfield import Array
from rsegen.obstacles.base import Grid, Shaped, elementwise, register
from rsegen.obstacles.ends import square_ends
from rsegen.params.sorts import Cell, Place


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Peak(Shaped):
    """A round hill inside the rectangle first..last: with softness 0 a table with vertical sides, with 100 a cone.

    On steep slopes, as of few blocks or a small softness, some levels have no block.
    """

    kind: ClassVar[str] = "peak"
    also: ClassVar[tuple[str, ...]] = ("hill", "pyramid", "cone", "mountain")

    def overhang(self, grid: Grid) -> float:
        """Return 0: the peak stays inside its rectangle."""
        return 0.0

    @elementwise
    def profile(self, x: Array, y: Array, first: Cell, last: Cell, grid: Grid) -> Array:
        """Return clip((R - d) / w, 0, 1), as in the module's docstring; if w = 0, 1 inside R and 0 outside."""
        half_x, half_y = ((abs(a - b) + 1) / 2 for a, b in zip(first, last, strict=True))
        radius = np.minimum(half_x, half_y)
        middle_x, middle_y = (first[0] + last[0]) / 2, (first[1] + last[1]) / 2

        def distance(x: Array, y: Array) -> Array:
            dx, dy = (x - middle_x) * (radius / half_x), (y - middle_y) * (radius / half_y)
            return np.asarray(np.sqrt(dx**2 + dy**2))

        d, d0 = distance(x, y), distance(np.floor(middle_x), np.floor(middle_y))
        w = self.softness / 100 * (radius - d0)
        return np.clip((radius - d) / w, 0, 1) if np.all(w) else np.where(d < radius, 1.0, 0.0)

    @elementwise
    def ends(self, grid: Grid, first: Place, last: Place, rng: np.random.Generator) -> tuple[Cell, Cell]:
        """Return ends; random ones make a square inside the map, with a random side of L/2..L if no side is given."""
        return square_ends(grid.shape, grid.chunk_size, first, last, rng)
