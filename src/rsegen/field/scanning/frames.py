"""Frames round a field: cells of one height at its rim, or round every chunk."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from rsegen.field.scanning.reading import Reading
from rsegen.field.stepfield import Mask, StepField, framed
from rsegen.params.places import Cell

_MOST_OTHERS = 0.02
"""Share of the cells of a frame that may be of another height, as misread."""


@dataclass(frozen=True, kw_only=True)
class Frames:
    """boundary and side of a chunk as in recipes; blocks: along x and y without frames; height: metres."""

    boundary: str
    side: int | None
    blocks: Cell
    height: float = 0.0

    @cached_property
    def cells(self) -> Mask:
        """Which cells of the field, frames counted, are frames."""
        _, frame = framed(np.zeros(self.blocks, dtype=np.int16), self.side or max(self.blocks), self.boundary)
        return frame

    @property
    def shape(self) -> Cell:
        """Cells along x and y, frames counted."""
        return self.cells.shape[0], self.cells.shape[1]


@dataclass(frozen=True, kw_only=True)
class KnownFrames(Frames):
    """The frames of a field that is known."""

    field: StepField

    @cached_property
    def cells(self) -> Mask:
        """Which cells of the field are frames."""
        return self.field.frame


def frames_of(reading: Reading, unit: float, boundary: str | None = None, side: int | None = None) -> Frames | None:
    """The frames that a field has if all cells of them are equally high; None if it has none.

    unit: of heights [m]; boundary, side: those to look for; else frames round every chunk are tried first, from small
    chunks to large ones.
    """
    n_x, n_y = reading.heights.shape
    sides = [side] if side else range(2, min(n_x, n_y) - 1)
    divided = [
        Frames(boundary="divided", side=own, blocks=(n_x // (own + 2) * own, n_y // (own + 2) * own))
        for own in sides
        if n_x % (own + 2) == 0 and n_y % (own + 2) == 0 and (n_x, n_y) != (own + 2, own + 2)
    ]
    outer = [Frames(boundary="outer", side=side or int(np.gcd(n_x - 2, n_y - 2)), blocks=(n_x - 2, n_y - 2))]
    tried = divided * (boundary != "outer") + outer * (boundary != "divided" and min(n_x, n_y) > 3)
    for frames in tried:
        height = _height(reading, unit, frames.cells)
        if height is not None:
            return replace(frames, height=height)
    return None


def _height(reading: Reading, unit: float, frame: Mask) -> float | None:
    """The height that all frame cells have which were seen [m]; None if they differ, or are the ground."""
    heights = reading.heights[frame & reading.seen]
    if len(heights) < frame.sum() / 2:
        return None
    height = float(np.median(heights))
    others = np.abs(heights - height) > unit / 2
    return height if height > unit / 4 and others.mean() <= _MOST_OTHERS else None
