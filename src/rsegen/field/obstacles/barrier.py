"""The profile of both barriers: a ridge along a segment that slopes down on all sides.

The horizontal barrier of the paper's figure 1.

The diagonal barrier of the paper's figure 2.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from rsegen.errors import ParameterError
from rsegen.field.obstacles.base import Grid, Shaped, register
from rsegen.field.stepfield import Array
from rsegen.params.sorts import ANYWHERE, Cell, Place
from rsegen.params.streams import randint


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


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class HorizontalBarrier(Barrier):
    """A straight ridge along x or y. Without `first` and `last`, it runs from one map edge to the opposite one."""

    kind: ClassVar[str] = "horizontal_barrier"

    def check(self, first: Place, last: Place) -> None:
        """Raise a ParameterError if the ends share neither x nor y."""
        if not _shareable(first, last):
            ends = f"first {list(first)} and last {list(last)}"
            raise ParameterError("last", f"{ends} share neither x nor y; a horizontal barrier needs the same x or y")

    def ends(self, grid: Grid, first: Place, last: Place, rng: np.random.Generator) -> tuple[Cell, Cell]:
        """Ends with one common coordinate, which is random if not given; across the map if no end is given."""
        axes = _shareable(first, last)
        shared = axes[randint(rng, 0, len(axes) - 1)]
        line = _given(first[shared], last[shared])
        at = randint(rng, 0, grid.shape[shared] - 1) if line is None else line
        cells = grid.shape[1 - shared]
        start, stop = first[1 - shared], last[1 - shared]
        if start == stop == "random":
            start, stop = 0, cells - 1
        ends = [randint(rng, 0, cells - 1) if end == "random" else end for end in (start, stop)]
        one, other = ((end, at) if shared else (at, end) for end in ends)
        return one, other


def _shareable(first: Place, last: Place) -> list[int]:
    """The axes (0: x, 1: y) on which both ends can have one coordinate; those on which they are given so, if any."""
    given = [axis for axis in (0, 1) if first[axis] == last[axis] != "random"]
    return given or [axis for axis in (0, 1) if "random" in (first[axis], last[axis])]


def _given(one: int | str, other: int | str) -> int | None:
    numbers = [at for at in (one, other) if isinstance(at, int)]
    return numbers[0] if numbers else None


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class DiagonalBarrier(Barrier):
    """A straight ridge in any direction. Without `first` and `last`, its ends are drawn on two opposite map edges."""

    kind: ClassVar[str] = "diagonal_barrier"

    def ends(self, grid: Grid, first: Place, last: Place, rng: np.random.Generator) -> tuple[Cell, Cell]:
        """Without given ends, a random cell on each of two opposite map edges; else random coordinates are uniform."""
        if first == last == ANYWHERE:
            across = randint(rng, 0, 1)
            opposite: tuple[Place, Place] = ((0, "random"), (grid.n_x - 1, "random"))
            upright: tuple[Place, Place] = (("random", 0), ("random", grid.n_y - 1))
            first, last = upright if across else opposite
        return Barrier.ends(self, grid, first, last, rng)
