"""The horizontal barrier of the paper's figure 1."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from rsegen.errors import ParameterError
from rsegen.field.obstacles.barrier import Barrier
from rsegen.field.obstacles.base import Grid, register
from rsegen.params.places import Cell, Place
from rsegen.params.streams import randint


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
