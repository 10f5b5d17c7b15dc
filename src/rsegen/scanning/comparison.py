"""Cell by cell: what stands, held against the field that should stand."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from rsegen.errors import ParameterError
from rsegen.field.stepfield import Array, Mask, StepField

_FEW_WRONG = 0.5
"""Share of wrong cells up to which two maps are taken for the same one, turned."""


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Comparison:
    """heights: (n_x, n_y), of what stands [m], nan where it is not known; wanted: the field that should stand;
    tolerance: heights that differ by less are equal [m]; turns: by how many quarter turns what stands was turned
    counterclockwise to lie on the wanted field.
    """

    heights: Array
    wanted: StepField
    tolerance: float
    turns: int = 0

    @property
    def seen(self) -> Mask:
        """Which cells have a height."""
        return np.isfinite(self.heights)

    @property
    def differences(self) -> Array:
        """By how much what stands is too high [m], 0 where it is right or not known; (n_x, n_y)."""
        off = np.where(self.seen, np.nan_to_num(self.heights) - self.wanted.heights, 0)
        return np.where(np.abs(off) >= self.tolerance, off, 0)

    @property
    def wrong(self) -> Mask:
        """Which cells have another height than they should."""
        return np.asarray(self.differences != 0)

    @property
    def is_equal(self) -> bool:
        """Whether every cell is known to be right."""
        return bool(self.seen.all() and not self.wrong.any())

    def changes(self) -> Iterator[tuple[int, int, float, float]]:
        """x, y, height [m] and wanted height [m] of every cell that is wrong, frames counted; row by row from y = 0."""
        for y, x in np.argwhere(self.wrong.T):
            yield int(x), int(y), float(self.heights[x, y]), float(self.wanted.heights[x, y])


def compared(stands: StepField, wanted: StepField) -> Comparison:
    """Two fields held against each other; a ParameterError if they do not have the same cells.

    What stands is turned by quarter turns if it then agrees with more cells, and with most of them: a real field, and a
    scan of it, does not say which side is south.
    """
    heights = stands.heights
    shapes = heights.shape, heights.shape[::-1]
    if wanted.shape not in shapes:
        sizes = " and ".join(f"{n_x} x {n_y}" for n_x, n_y in (stands.shape, wanted.shape))
        raise ParameterError("MAP", f"the maps have {sizes} cells, frames counted; give maps of one size")
    if stands.block_width != wanted.block_width:
        widths = " and ".join(f"{field.block_width * 100:g}" for field in (stands, wanted))
        raise ParameterError("MAP", f"the blocks are {widths} cm wide; give maps of equal blocks")
    found = [
        Comparison(heights=np.rot90(heights, turns), wanted=wanted, tolerance=1e-6, turns=turns)
        for turns in range(4)
        if shapes[turns % 2] == wanted.shape
    ]
    best = min(found, key=lambda each: int(each.wrong.sum()))
    return best if best.wrong.mean() < _FEW_WRONG else found[0]
