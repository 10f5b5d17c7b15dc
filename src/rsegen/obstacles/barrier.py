"""Barriers: straight ridges along a segment that slope down on all sides (the paper's figures 1 and 2).

    f = 1 for d <= 1/2;  f = max(0, 1 - (d - 1/2) / w) beyond      d: distance in cells from the segment first..last

The half cell on each side of the axis makes a horizontal crest one cell wide. The width w of the slopes is a share of
the chunk size L, so that softness 100 spreads a ridge over a whole chunk on each side. The cost is a few operations for
each cell of the rectangle of both ends, w + 1/2 cells wider on every side. Without slopes, a diagonal ridge is a chain
of cells of which some meet at corners only.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import ClassVar

import numpy as np

from rsegen.errors import ParameterError
from rsegen.field.stepfield import Array
from rsegen.obstacles.base import Grid, Obstacle, Sloped, elementwise, register
from rsegen.obstacles.ends import ends_of_one
from rsegen.params.sorts import ANYWHERE, Cell, Place
from rsegen.params.streams import randint


class Barrier(Sloped):
    """A ridge whose profile is 1 within half a cell of the segment first..last and falls to 0 over w cells."""

    __slots__ = ()

    @elementwise
    def profile(self, x: Array, y: Array, first: Cell, last: Cell, grid: Grid) -> Array:
        """Return 1 near the axis and 1 - (d - 1/2) / w on the slopes, with the distance d from the segment."""
        (x1, y1), (x2, y2) = first, last
        along_x, along_y = x2 - x1, y2 - y1
        squared = along_x**2 + along_y**2
        # The nearest point of the segment is at the share t of the way; 0 / 1 for a segment of one cell.
        t = np.clip(((x - x1) * along_x + (y - y1) * along_y) / np.maximum(squared, 1), 0, 1)
        return self.sloped(np.sqrt((x - x1 - t * along_x) ** 2 + (y - y1 - t * along_y) ** 2), grid)


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class HorizontalBarrier(Barrier):
    """A straight ridge along x or y. Without `first` and `last`, it runs from one map edge to the opposite one."""

    kind: ClassVar[str] = "horizontal_barrier"
    also: ClassVar[tuple[str, ...]] = ("barrier", "wall", "ridge", "bar")

    def __post_init__(self) -> None:
        Obstacle.__post_init__(self)
        if self.first and self.last and not _shareable(self.first, self.last):
            ends = f"first {list(self.first)} and last {list(self.last)}"
            raise ParameterError("last", f"{ends} share neither x nor y; a horizontal barrier needs the same x or y")

    @elementwise
    def ends(self, grid: Grid, first: Place, last: Place, rng: np.random.Generator) -> tuple[Cell, Cell]:
        """Return ends that share x or y; missing coordinates are drawn; without ends the barrier spans the map."""
        return ends_of_one([partial(_ends_along, grid, first, last, axis) for axis in _shareable(first, last)], rng)


def _ends_along(grid: Grid, first: Place, last: Place, shared: int, rng: np.random.Generator) -> tuple[Cell, Cell]:
    """Return ends of one coordinate on the axis `shared`."""
    fixed = [at for at in (first[shared], last[shared]) if isinstance(at, int)]  # equal if both are
    line = fixed[0] if fixed else randint(rng, 0, grid.shape[shared] - 1)
    cells = grid.shape[1 - shared]
    start, stop = first[1 - shared], last[1 - shared]
    if start == stop == "random":
        start, stop = 0, cells - 1
    start, stop = (randint(rng, 0, cells - 1) if end == "random" else end for end in (start, stop))
    return ((start, line), (stop, line)) if shared else ((line, start), (line, stop))


def _shareable(first: Place, last: Place) -> list[int]:
    """Return the axes (0: x, 1: y) on which both ends can have one coordinate; only axes where both give it, if any."""
    fixed = [axis for axis in (0, 1) if first[axis] == last[axis] != "random"]
    return fixed or [axis for axis in (0, 1) if "random" in (first[axis], last[axis])]


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class DiagonalBarrier(Barrier):
    """A straight ridge in any direction. Without `first` and `last`, its ends are drawn on two opposite map edges."""

    kind: ClassVar[str] = "diagonal_barrier"
    also: ClassVar[tuple[str, ...]] = ("barrier", "diagonal")

    @elementwise
    def ends(self, grid: Grid, first: Place, last: Place, rng: np.random.Generator) -> tuple[Cell, Cell]:
        """Return random cells on two opposite map edges if no coordinate is given; else random ones are uniform."""
        if not first == last == ANYWHERE:
            return Barrier.ends(self, grid, first, last, rng)
        opposite: tuple[Place, Place] = ((0, "random"), (grid.n_x - 1, "random"))
        upright: tuple[Place, Place] = (("random", 0), ("random", grid.n_y - 1))
        return ends_of_one([partial(Barrier.ends, self, grid, *ends) for ends in (opposite, upright)], rng)
