"""The platform: an even rectangle on which a robot can start, or that it has to reach.

    f = t inside, t max(0, 1 - (d - 1/2) / w) outside      t = level / (levels - 1)

d is the distance in cells from the rectangle, w the width of the slopes, as of a barrier. The cost is a few operations
per cell of the rectangle and its slopes. Later obstacles may cover a platform, so it belongs behind them in the recipe.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from rsegen.errors import ParameterError
from rsegen.field.obstacles.base import Grid, Obstacle, Patch, Shaped, random_ends, register
from rsegen.field.stepfield import Array
from rsegen.params.sorts import Cell, Integer, Place, Size2D


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Platform(Shaped):
    """An even rectangle for the start or the goal of a robot; with softness, slopes lead up to it on all sides."""

    kind: ClassVar[str] = "platform"

    size: Annotated[
        Cell, Size2D(help="cells along x and y if first and last do not give them, at most those of the map")
    ] = (6, 6)
    level: Annotated[
        int | None, Integer(0, 32766, unit="units", help="level of its cells, 0: the ground; default: the highest")
    ] = None

    def __post_init__(self) -> None:
        Obstacle.__post_init__(self)
        if self.top >= self.levels:
            raise ParameterError("level", f"{self.top} is more than the highest level, {self.levels - 1}")

    @property
    def top(self) -> int:
        """Level of the cells of the rectangle."""
        return self.levels - 1 if self.level is None else self.level

    def ends(self, grid: Grid, first: Place, last: Place, rng: np.random.Generator) -> tuple[Cell, Cell]:
        """Return ends; random ones make a rectangle of `size` inside the map."""
        (x1, x2), (y1, y2) = (
            random_ends(a, b, min(own, cells) - 1, cells, rng)
            for a, b, own, cells in zip(first, last, self.size, grid.shape, strict=True)
        )
        return (x1, y1), (x2, y2)

    def run_out(self, grid: Grid) -> float:
        """Return the width of the slopes in cells: w = (softness / 100) * L, with the chunk size L."""
        return self.softness / 100 * grid.chunk_size

    def reach(self, grid: Grid) -> float:
        """Return w + 1/2 cells, beyond which the profile is 0."""
        return self.run_out(grid) + 0.5

    def profile(self, x: Array, y: Array, first: Cell, last: Cell, grid: Grid) -> Array:
        """Return level / (levels - 1) inside, times 1 - (d - 1/2) / w at a distance d from the rectangle."""
        (x1, x2), (y1, y2) = (sorted(ends) for ends in zip(first, last, strict=True))
        away_x, away_y = np.maximum(np.maximum(x1 - x, x - x2), 0), np.maximum(np.maximum(y1 - y, y - y2), 0)
        beyond = np.hypot(away_x, away_y) - 0.5
        w = self.run_out(grid)
        slope = np.maximum(0.0, 1 - beyond / w) if w else 0.0
        return np.asarray(np.where(beyond <= 0, 1.0, slope) * (self.top / (self.levels - 1)))

    @property
    def draws_nothing(self) -> bool:
        """Return whether `patch` is still the one of this class."""
        return type(self).patch is Platform.patch

    def patch(self, grid: Grid, first: Cell, last: Cell, rng: np.random.Generator) -> Patch:
        """Return the levels floor((n - 1) f); the rectangle is covered also at level 0, the slopes from level 1 on."""
        patch = Shaped.patch(self, grid, first, last, rng)
        low, high = (tuple(map(best, zip(first, last, strict=True))) for best in (min, max))
        part = tuple(
            slice(begin - window.start, end + 1 - window.start)
            for window, begin, end in zip(patch.window, low, high, strict=True)
        )
        footprint = patch.footprint.copy()
        footprint[part] = True
        return patch._replace(footprint=footprint)
