"""Which cells of a grid are the field: a rectangle round all that is above the ground, or where a known map fits.

Frames round a field: cells of one height at its rim, or round every chunk.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from rsegen.errors import ScanError
from rsegen.field.stepfield import Array, Ints, Mask, StepField, framed
from rsegen.params.sorts import Cell
from rsegen.scanning.levels import Reading

_NEIGHBOURS = 2
"""Blocks at most this many cells apart belong to the same field."""

_MOST_INSIDE = 0.85
"""Places are tried that have so many of the raised cells inside, as a share of the most that any place has."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Fit:
    """Where a known field lies in a reading: quarter turns, corner, and how many cells that were seen agree."""

    turns: int
    corner: Cell
    agree: int
    seen: int


def extent_of(reading: Reading, unit: float, shape: Cell | None = None) -> tuple[Cell, Cell]:
    """Corner and shape of the field: the rectangle round the largest group of raised cells.

    shape: cells along x and y, frames counted, if they are known; the rectangle of these that has the most of them.
    """
    raised = reading.levels(unit) > 0
    if not raised.any():
        raise ScanError("no cell is above the ground; give other blocks, or a scan with more points")
    if shape is None:
        group = _largest_group(raised)
        i, j = np.nonzero(group)
        return (int(i.min()), int(j.min())), (int(np.ptp(i)) + 1, int(np.ptp(j)) + 1)
    inside = _counts_within(np.pad(raised, [(cells, cells) for cells in shape]), shape)
    best = np.argwhere(inside == inside.max())
    middle = best[len(best) // 2] - shape
    return (int(middle[0]), int(middle[1])), shape


def _counts_within(found: Mask, shape: Cell) -> Ints:
    """How many true cells are in each rectangle of a shape."""
    sums = np.pad(found.astype(np.int64).cumsum(axis=0).cumsum(axis=1), [(1, 0), (1, 0)])
    n_x, n_y = shape
    return np.asarray(sums[n_x:, n_y:] - sums[:-n_x, n_y:] - sums[n_x:, :-n_y] + sums[:-n_x, :-n_y])


def _largest_group(raised: Mask) -> Mask:
    """The raised cells of the group that has most of them; cells of one group are near one another."""
    labels = np.where(raised, np.arange(1, raised.size + 1).reshape(raised.shape), 0)
    while True:
        spread = _spread(labels)
        joined = np.where(raised, spread, 0)
        if np.array_equal(joined, labels):
            break
        labels = joined
    return np.asarray(labels == np.bincount(labels[raised]).argmax())


def _spread(labels: Ints) -> Ints:
    """The largest label within so many cells along x and y of each."""
    found = labels
    for axis in (0, 1):
        padded = np.pad(found, [(_NEIGHBOURS, _NEIGHBOURS) if side == axis else (0, 0) for side in (0, 1)])
        found = np.lib.stride_tricks.sliding_window_view(padded, 2 * _NEIGHBOURS + 1, axis=axis).max(axis=-1)
    return np.asarray(found)


def best_fit(reading: Reading, heights: Array, tolerance: float) -> Fit:
    """Where a field of known heights (n_x, n_y) [m] agrees with the most cells, over all quarter turns.

    Cells agree whose heights differ by less than the tolerance [m]; raised cells beside the field count against it.
    """
    found = []
    for turns in range(4):
        turned = np.pad(reading.quarter_turned(turns).heights, [(n, n) for n in heights.shape], constant_values=np.nan)
        with np.errstate(invalid="ignore"):
            raised = turned > tolerance
            inside = _counts_within(raised, (heights.shape[0], heights.shape[1]))
            for i, j in np.argwhere(inside >= _MOST_INSIDE * inside.max()):
                window = turned[i : i + heights.shape[0], j : j + heights.shape[1]]
                agree = int((np.abs(window - heights) < tolerance).sum())
                outside = int(raised.sum() - inside[i, j])
                corner = int(i) - heights.shape[0], int(j) - heights.shape[1]
                found.append((agree - outside, agree, int(np.isfinite(window).sum()), -turns, corner))
    _, agree, seen, turns, corner = max(found)
    return Fit(turns=-turns, corner=corner, agree=agree, seen=seen)


_MOST_OTHERS = 0.02
"""Share of the cells of a frame that may be of another height, as misread."""


@dataclass(frozen=True, kw_only=True)
class FrameLayout:
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
class KnownFrameLayout(FrameLayout):
    """The frames of a field that is known."""

    field: StepField

    @cached_property
    def cells(self) -> Mask:
        """Which cells of the field are frames."""
        return self.field.frame


def frames_of(
    reading: Reading, unit: float, boundary: str | None = None, side: int | None = None
) -> FrameLayout | None:
    """The frames that a field has if all cells of them are equally high; None if it has none.

    unit: of heights [m]; boundary, side: those to look for; else frames round every chunk are tried first, from small
    chunks to large ones.
    """
    n_x, n_y = reading.heights.shape
    sides = [side] if side else range(2, min(n_x, n_y) - 1)
    divided = [
        FrameLayout(boundary="divided", side=own, blocks=(n_x // (own + 2) * own, n_y // (own + 2) * own))
        for own in sides
        if n_x % (own + 2) == 0 and n_y % (own + 2) == 0 and (n_x, n_y) != (own + 2, own + 2)
    ]
    outer = [FrameLayout(boundary="outer", side=side or int(np.gcd(n_x - 2, n_y - 2)), blocks=(n_x - 2, n_y - 2))]
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
