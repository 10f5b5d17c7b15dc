"""Comparison of a real field with the field that should stand there, cell by cell.

A real field does not say which side is south, so the quarter turn counts at which most cells agree. It fails for maps
that are symmetric but for a few blocks: then several turns agree equally well, and the first of them is taken.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from rsegen.errors import ParameterError
from rsegen.field.stepfield import Array, Mask, StepField
from rsegen.params.sorts import NANOMETRE_DIGITS

_FEW_WRONG = 0.5
"""Share of wrong cells below which two maps are taken for the same one, turned: unrelated fields of five levels
differ in about four of five cells at any turn."""


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Comparison:
    """The heights of a real field, on the cells of the field that should stand there.

    heights: (n_x, n_y) [m], nan where it is not known; wanted: the field that should stand; tolerance: heights that
    differ by less are equal [m]; turns: quarter turns counterclockwise after which the heights lie on the wanted field.
    """

    heights: Array
    wanted: StepField
    tolerance: float
    turns: int = 0

    @property
    def seen(self) -> Mask:
        """Cells that have a height."""
        return np.isfinite(self.heights)

    @property
    def differences(self) -> Array:
        """Height above the wanted height [m], 0 if it is right or not known; (n_x, n_y)."""
        off = np.where(self.seen, np.nan_to_num(self.heights) - self.wanted.heights, 0)
        return np.where(np.abs(off) >= self.tolerance, off, 0)

    @property
    def wrong(self) -> Mask:
        """Cells that have another height than they should."""
        return np.asarray(self.differences != 0)

    @property
    def is_equal(self) -> bool:
        """Return whether every cell is known to be right."""
        return bool(self.seen.all() and not self.wrong.any())

    def changes(self) -> Iterator[tuple[int, int, float, float]]:
        """Yield x, y, height [m] and wanted height [m] of every wrong cell, frames counted; row by row from y = 0."""
        for y, x in np.argwhere(self.wrong.T):
            yield int(x), int(y), float(self.heights[x, y]), float(self.wanted.heights[x, y])


def compared(stands: StepField, wanted: StepField) -> Comparison:
    """Compare two fields; a ParameterError if they do not have the same cells.

    The field that stands is turned by quarter turns if it then agrees with more cells, and with most of them.
    """
    heights = stands.heights
    shapes = heights.shape, heights.shape[::-1]
    if wanted.shape not in shapes:
        sizes = " and ".join(f"{n_x} x {n_y}" for n_x, n_y in (stands.shape, wanted.shape))
        raise ParameterError("", f"the maps have {sizes} cells, frames counted; use maps of one size")
    if round(stands.block_width - wanted.block_width, NANOMETRE_DIGITS):
        widths = " and ".join(f"{field.block_width * 100:g}" for field in (stands, wanted))
        raise ParameterError("", f"the blocks are {widths} cm wide; use maps of equal blocks")
    # Of the turns that fit (two, or four of a square field) the one with the fewest wrong cells, if these are few.
    comparisons = [
        Comparison(heights=np.rot90(heights, turns), wanted=wanted, tolerance=1e-6, turns=turns)
        for turns in range(4)
        if shapes[turns % 2] == wanted.shape
    ]
    best = min(comparisons, key=lambda comparison: int(comparison.wrong.sum()))
    return best if best.wrong.mean() < _FEW_WRONG else comparisons[0]
