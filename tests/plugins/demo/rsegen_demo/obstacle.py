"""An obstacle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

from rsegen.field.stepfield import Array
from rsegen.obstacles.base import Grid, Shaped
from rsegen.params.sorts import Cell, Integer


@dataclass(frozen=True, kw_only=True, slots=True)
class Ramp(Shaped):
    """Steps that rise along x from first to last."""

    kind: ClassVar[str] = "ramp"

    tread: Annotated[int, Integer(1, 100, unit="blocks", help="depth of a step")] = 1

    def overhang(self, grid: Grid) -> float:
        """It stays inside its rectangle."""
        return 0.0

    def profile(self, x: Array, y: Array, first: Cell, last: Cell, grid: Grid) -> Array:
        """From 0 at the first cell to 1 at the last, the same for every y."""
        run = max(abs(last[0] - first[0]), 1)
        return abs(x - first[0]) // self.tread * self.tread / run + 0 * y
