"""The platform: an even rectangle on which a robot can start, or that it has to reach.

    f = t inside, t max(0, 1 - (d - 1/2) / w) outside      t = level / (levels - 1)

d is the distance in cells from the rectangle, w the width of the slopes, as of a barrier. The cost is a few operations
per cell of the rectangle and its slopes. Later obstacles may cover a platform, so it belongs behind them in the recipe.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from rsegen.errors import ParameterError
from rsegen.field.stepfield import Array, Ints, Levels, Mask
from rsegen.obstacles.base import Grid, Obstacle, Sloped, elementwise, register
from rsegen.obstacles.ends import ends_of_size
from rsegen.params.sorts import Cell, Integer, Place, Size2D


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Platform(Sloped):
    """An even rectangle for the start or the goal of a robot; with softness, slopes lead up to it on all sides."""

    kind: ClassVar[str] = "platform"
    also: ClassVar[tuple[str, ...]] = ("box", "block", "plateau")

    size: Annotated[
        Sequence[int], Size2D(help="cells along x and y if first and last do not give them, at most those of the map")
    ] = (6, 6)
    level: Annotated[
        int | None,
        Integer(
            0,
            32766,
            unit="units",
            usual=(0, 10),
            help="level of its cells, 0: the ground; default: the highest, levels - 1",
        ),
    ] = None

    def __post_init__(self) -> None:
        Obstacle.__post_init__(self)
        if self.top >= self.levels:
            raise ParameterError("level", f"{self.top} is more than the highest level, {self.levels - 1}")

    @property
    def top(self) -> int:
        """Level of the cells of the rectangle."""
        return self.levels - 1 if self.level is None else self.level

    @elementwise
    def ends(self, grid: Grid, first: Place, last: Place, rng: np.random.Generator) -> tuple[Cell, Cell]:
        """Return ends; random ones make a rectangle of `size` inside the map."""
        (own_x, own_y), (n_x, n_y) = self.size, grid.shape
        return ends_of_size(grid.shape, first, last, (min(own_x, n_x), min(own_y, n_y)), rng)

    @elementwise
    def profile(self, x: Array, y: Array, first: Cell, last: Cell, grid: Grid) -> Array:
        """Return level / (levels - 1) inside, times 1 - (d - 1/2) / w at a distance d from the rectangle."""
        away = np.hypot(_away(x, first[0], last[0]), _away(y, first[1], last[1]))
        return self.sloped(away, grid) * (self.top / (self.levels - 1))

    @elementwise
    def covers(self, levels: Levels, x: Ints, y: Ints, first: Cell, last: Cell) -> Mask:
        """Return the mask of the cells that it covers: the rectangle also at level 0, the slopes from level 1 on."""
        is_inside = (_away(x, first[0], last[0]) == 0) & (_away(y, first[1], last[1]) == 0)
        return np.asarray((levels >= 1) | is_inside)


def _away(at: Array | Ints, first: int, last: int) -> Array:
    """Return the distance of each coordinate from the interval between two others; 0 inside."""
    return np.asarray(np.maximum(np.maximum(np.minimum(first, last) - at, at - np.maximum(first, last)), 0))
