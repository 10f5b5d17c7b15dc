"""Rails: thin raised lines to step over, across a way or as closed rings around the middle.

    n cells, m rails of width w, across:   rail k begins at ((2 k + 1) n - m w) / (2 m), rounded down

so that the spaces between rails differ by one cell at most. Ring k begins k s cells from the rim, where s is half of
the shorter side over the number of rings, rounded down. As many rails are made as fit with a cell between them. The
cost is a few operations per cell.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from rsegen.field.stepfield import Array, Levels, Mask
from rsegen.obstacles.base import Layout, register, to_rim
from rsegen.params.sorts import Cell, Choice, Integer


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Rails(Layout):
    """Thin raised lines at equal distances, across x or y, or as closed rings; all as high as the highest level."""

    kind: ClassVar[str] = "rails"
    also: ClassVar[tuple[str, ...]] = ("pipe", "pipes")

    shape: Annotated[
        str, Choice(("rings", "x", "y"), help="rings: around the middle; x, y: one after the other along x or y")
    ] = "rings"
    rails: Annotated[int, Integer(1, 1000, usual=(1, 10), help="number of rails or rings, if all of them fit")] = 2
    rail_width: Annotated[int, Integer(1, 1000, unit="blocks", usual=(1, 10), help="width of a rail")] = 1

    def laid_out(self, shape: Cell, drawn: Array) -> tuple[Levels, Mask]:
        """Return the level of the rails, which alone are covered."""
        if self.shape == "rings":
            half = (min(shape) + 1) // 2
            rings = min(self.rails, max(half // (self.rail_width + 1), 1))
            spacing = half // rings
            rim = to_rim(shape)
            covered: Mask = (rim < rings * spacing) & (rim % spacing < self.rail_width)
        else:
            along = "xy".index(self.shape)
            cells = shape[along]
            rails = min(self.rails, max(cells // (self.rail_width + 1), 1))
            starts = ((2 * np.arange(rails) + 1) * cells - rails * self.rail_width) // (2 * rails)
            covered = np.zeros(shape, dtype=bool)
            for start in starts.tolist():
                rail = slice(start, start + self.rail_width)
                covered[rail if along == 0 else (slice(None), rail)] = True
        return np.where(covered, np.int16(self.levels - 1), np.int16(0)), covered
