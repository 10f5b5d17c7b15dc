"""Waves: crests and troughs as on a washboard, across x or y, or across both.

    f(i) = (1 - cos(2 pi m (i + 1/2) / n)) / 2      level = (levels - 1) f, to the nearest whole number

with m waves on the n cells along an axis, so that both rims are in a trough. Across both axes f is the mean of the two:
hills and hollows. The cost is a few operations per cell. Trainers of legged robots have the same terrain in metres
(`num_waves`, `amplitude`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from rsegen.field.stepfield import Array, Levels, Mask
from rsegen.obstacles.base import Layout, register
from rsegen.obstacles.given import SLACK
from rsegen.params.sorts import Cell, Choice, Integer


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Waves(Layout):
    """Waves of equal length: one crest after the other along x or y, or hills and hollows."""

    kind: ClassVar[str] = "waves"
    also: ClassVar[tuple[str, ...]] = ("wave", "sine", "washboard", "hills")

    shape: Annotated[
        str, Choice(("both", "x", "y"), help="x, y: one crest after the other along x or y; both: hills and hollows")
    ] = "both"
    waves: Annotated[int, Integer(1, 1000, usual=(1, 10), help="number of waves along each side")] = 2

    def laid_out(self, shape: Cell, drawn: Array) -> tuple[Levels, Mask]:
        """Return the level of each cell; all cells are covered."""
        along_x, along_y = (
            (1 - np.cos(2 * np.pi * self.waves * (np.arange(cells) + 0.5) / cells)) / 2 for cells in shape
        )
        f = {"x": along_x[:, None], "y": along_y, "both": (along_x[:, None] + along_y) / 2}[self.shape]
        levels = np.floor((self.levels - 1) * f + 0.5 + SLACK).astype(np.int16)
        return np.broadcast_to(levels, shape), np.ones(shape, dtype=bool)
