"""The pit: a hole with vertical walls in ground that is high enough, with an island or a beam if wanted.

All of it lies `levels` - 1 units below the ground. A `gap_width` leaves the ground in the middle as it is, so that the
hole is a gap all around an island; a `beam_width` leaves a bridge in the middle, from one end to the other. What is
left is not covered: earlier obstacles stay there. The cost is a few operations per cell of the rectangle.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from rsegen.field.stepfield import Array, Levels, Mask
from rsegen.obstacles.base import Grid, Layout, Obstacle, register, to_rim
from rsegen.params.sorts import ANYWHERE, Cell, Choice, Integer, Place


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Pit(Layout):
    """A hole in the ground: a whole rectangle, a gap around an island, or with a beam across."""

    kind: ClassVar[str] = "pit"
    also: ClassVar[tuple[str, ...]] = ("hole", "gap", "ditch", "trench")
    default_place: ClassVar[str] = Obstacle.default_place

    gap_width: Annotated[
        int | None,
        Integer(1, 1000, unit="blocks", usual=(1, 10), help="width of the hole around an island; default: no island"),
    ] = None
    beam_width: Annotated[
        int | None,
        Integer(1, 1000, unit="blocks", usual=(1, 10), help="width of a beam across the middle; default: no beam"),
    ] = None
    beam_along: Annotated[str, Choice(("x", "y"), help="direction of the beam")] = "x"

    def default_ends(self, grid: Grid) -> tuple[Place, Place]:
        """Return random ends: a pit of the whole map would have no edge."""
        return ANYWHERE, ANYWHERE

    @property
    def level_range(self) -> tuple[int, int]:
        """The lowest and the highest level, counted from the ground."""
        return 1 - self.levels, 0

    def laid_out(self, shape: Cell, drawn: Array) -> tuple[Levels, Mask]:
        """Return the same depth everywhere; the island and the beam are not covered."""
        hole = np.ones(shape, dtype=bool) if self.gap_width is None else to_rim(shape) < self.gap_width
        if self.beam_width is not None:
            across = 1 - "xy".index(self.beam_along)
            start = max(shape[across] - self.beam_width, 0) // 2
            beam = slice(start, start + self.beam_width)
            hole[(slice(None), beam) if across else (beam, slice(None))] = False
        return np.full(shape, 1 - self.levels, dtype=np.int16), hole
