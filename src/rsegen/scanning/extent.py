"""The part of a cloud's grid that is the field, and the frames in it.

Three cases. Nothing is known: the rectangle around the largest group of raised cells. The size is known: the rectangle
of that size with the most raised cells. The map is known: the place and the quarter turn at which most heights agree.
A side is open if almost no cell next to it was seen, neither of the floor nor of a block: the field may go on there, so
the rectangle may be a row larger if that makes frames complete. Chunk sizes are tried until all cells of their frames
have one height:

     # # # # # # #
     # . . # . . #      side 2: the cells # are equally high, so they are frames; for any other side, blocks of
     # . . # . . #      several levels would be on the frames
     # # # # # # #

A rim of blocks of one level looks like that too. In a deck with holes the cells next to the rim are as high as it, so
it is no frame then; blocks inside of a frame have all levels.

Sums over rectangles come from one table of cumulative sums along both axes, so each place of a rectangle costs four
look-ups; a known map is compared at the best places only. A rim at level 0 looks like floor: then the size has to be
given.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations

import numpy as np

from rsegen.errors import ScanError
from rsegen.field.stepfield import Array, Ints, Mask, StepField, framed
from rsegen.params.sorts import Cell
from rsegen.scanning.levels import Reading

NEIGHBOURS = 2
"""Blocks at most this many cells apart belong to the same field.

2 leaps over one row at level 0, or one that no camera saw. With 1 such a row cuts the field in two; with more,
furniture next to the field belongs to it.
"""

_MOST_INSIDE = 0.85
"""Share of the raised cells of the best place that a place must have inside to be tried: cells that no camera saw,
and things next to the field, move the best count away from the field."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Fit:
    """The place of a known field in a reading: quarter turns, corner, cells that were seen, and those that agree."""

    turns: int
    corner: Cell
    agree: int
    seen: int


def extent_of(reading: Reading, unit: float, shape: Cell | None = None) -> tuple[Cell, Cell]:
    """Return corner and shape of the field: the rectangle around the largest group of raised cells.

    shape: cells along x and y, frames counted, if they are known; then the rectangle of this shape that has the most
    raised cells, and of equal ones the middle one.
    """
    raised = reading.levels(unit) > 0
    if not raised.any():
        raise ScanError("no cell is above the ground; set other blocks, or use a scan with more points")
    if shape is None:
        group = _largest_group(raised)
        i, j = np.nonzero(group)
        return (int(i.min()), int(j.min())), (int(np.ptp(i)) + 1, int(np.ptp(j)) + 1)
    # With a margin of one shape on every side, so that the rectangle may stick out of what was seen.
    inside = _counts_within(np.pad(raised, [(cells, cells) for cells in shape]), shape)
    best = np.argwhere(inside == inside.max())
    middle = best[int(np.square(best - best.mean(axis=0)).sum(axis=1).argmin())] - shape
    return (int(middle[0]), int(middle[1])), shape


_FEW_SEEN = 0.5
"""Share of the cells next to a side below which it is open: of more, some raised ones would have been seen."""


def open_sides(reading: Reading, corner: Cell, shape: Cell) -> tuple[str, ...]:
    """Return the sides of a rectangle next to which so few cells were seen that the field may go on there."""
    seen = reading.part((corner[0] - 1, corner[1] - 1), (shape[0] + 2, shape[1] + 2)).seen
    next_to = {"west": seen[0, 1:-1], "east": seen[-1, 1:-1], "south": seen[1:-1, 0], "north": seen[1:-1, -1]}
    return tuple(side for side, cells in next_to.items() if cells.mean() < _FEW_SEEN)


def unseen_sides(reading: Reading, corner: Cell, shape: Cell) -> tuple[str, ...]:
    """Return the sides of a rectangle of which, and next to which, almost no cell was seen: it may end elsewhere."""
    within = open_sides(reading, (corner[0] + 1, corner[1] + 1), (shape[0] - 2, shape[1] - 2))
    return tuple(side for side in open_sides(reading, corner, shape) if side in within)


def floor_rows(reading: Reading, unit: float) -> tuple[int, int, int, int]:
    """Return how many rows of cells of floor were seen next to all that is raised: west, east, south, north of it."""
    raised = reading.levels(unit) > 0
    if not raised.any():
        return 0, 0, 0, 0
    i, j = np.nonzero(raised)
    columns, rows = reading.seen[:, j.min() : j.max() + 1], reading.seen[i.min() : i.max() + 1]
    # Rows outwards from the raised cells; the product of those that were seen ends at the first gap.
    next_to = columns[: i.min()][::-1], columns[i.max() + 1 :], rows[:, : j.min()].T[::-1], rows[:, j.max() + 1 :].T
    west, east, south, north = (int(np.cumprod(side.mean(axis=1) >= _FEW_SEEN).sum()) for side in next_to)
    return west, east, south, north


FLOOR_ROWS = 2
"""Rows of cells of floor next to a field from which on it is floor for sure: a frame is one cell wide."""


def units_below(reading: Reading, unit: float) -> int:
    """Return how many units the ground is lower than where most tops are lowest: some blocks of a field without a floor
    may be lower, which next to a floor is a hole in it.
    """
    lowest = round(float(np.nanmin(reading.heights)) / unit) if reading.seen.any() else 0
    return -lowest if lowest < 0 and max(floor_rows(reading, unit)) < FLOOR_ROWS else 0


def raised_apart(reading: Reading, unit: float, corner: Cell, shape: Cell) -> int:
    """Return the number of raised cells outside of a rectangle."""
    return int((reading.levels(unit) > 0).sum() - (reading.part(corner, shape).levels(unit) > 0).sum())


_ON_LINE = 0.12
"""Share of a block by which a cloud that is cut at sides of blocks may end off a line of the grid, by noise."""


def whole_cloud(reading: Reading) -> tuple[Cell, Cell] | None:
    """Return corner and shape of all cells that are in a cloud that is cut at the sides of a field: it ends at lines of
    the grid. None if it ends elsewhere.
    """
    if reading.ends is None or (np.abs(reading.ends - np.rint(reading.ends)) >= _ON_LINE).any():
        return None
    ends = np.rint(reading.ends).astype(int)
    (i, j), (n_x, n_y) = ends[0].tolist(), np.diff(ends, axis=0)[0].tolist()
    return (i, j), (n_x, n_y)


def with_open_rows(reading: Reading, corner: Cell, shape: Cell) -> Iterator[tuple[Cell, Cell]]:
    """Yield corner and shape of a rectangle, and then of it with a row more on some of its open sides, on few first."""
    sides = open_sides(reading, corner, shape)
    for count in range(len(sides) + 1):
        for more in combinations(sides, count):
            (i, j), (n_x, n_y) = corner, shape
            yield (
                (i - ("west" in more), j - ("south" in more)),
                (n_x + ("west" in more) + ("east" in more), n_y + ("south" in more) + ("north" in more)),
            )


def _counts_within(cells: Mask, shape: Cell) -> Ints:
    """Return the number of true cells in each rectangle of a shape, from cumulative sums along both axes."""
    sums = np.pad(cells.astype(np.int64).cumsum(axis=0).cumsum(axis=1), [(1, 0), (1, 0)])
    n_x, n_y = shape
    return np.asarray(sums[n_x:, n_y:] - sums[:-n_x, n_y:] - sums[n_x:, :-n_y] + sums[:-n_x, :-n_y])


def _largest_group(raised: Mask) -> Mask:
    """Return the raised cells of the largest group: labels spread to near cells until every group has one label."""
    labels = np.where(raised, np.arange(1, raised.size + 1).reshape(raised.shape), 0)
    while True:
        spread = _spread(labels)
        joined = np.where(raised, spread, 0)
        if np.array_equal(joined, labels):
            break
        labels = joined
    return np.asarray(labels == np.bincount(labels[raised]).argmax())


def _spread(labels: Ints) -> Ints:
    """Return the largest label within NEIGHBOURS cells of each cell along x and y."""
    for axis in (0, 1):
        padded = np.pad(labels, [(NEIGHBOURS, NEIGHBOURS) if side == axis else (0, 0) for side in (0, 1)])
        labels = np.lib.stride_tricks.sliding_window_view(padded, 2 * NEIGHBOURS + 1, axis=axis).max(axis=-1)
    return np.asarray(labels)


def best_fit(reading: Reading, heights: Array, tolerance: float) -> Fit:
    """Return the place and quarter turn at which a field of known heights (n_x, n_y) [m] agrees with the most cells.

    Cells agree whose heights differ by less than the tolerance [m]; raised cells outside the field count against it.
    """
    fits = []
    for turns in range(4):
        # The reading with a margin of one field on every side, so that the field may stick out of what was seen.
        turned = np.pad(reading.quarter_turned(turns).heights, [(n, n) for n in heights.shape], constant_values=np.nan)
        with np.errstate(invalid="ignore"):
            raised = turned > tolerance
            inside = _counts_within(raised, (heights.shape[0], heights.shape[1]))
            for i, j in np.argwhere(inside >= _MOST_INSIDE * inside.max()):
                window = turned[i : i + heights.shape[0], j : j + heights.shape[1]]
                agree = int((np.abs(window - heights) < tolerance).sum())
                outside = int(raised.sum() - inside[i, j])
                corner = int(i) - heights.shape[0], int(j) - heights.shape[1]
                fits.append((agree - outside, agree, int(np.isfinite(window).sum()), -turns, corner))
    _, agree, seen, turns, corner = max(fits)  # of equally good ones that with fewer turns
    return Fit(turns=-turns, corner=corner, agree=agree, seen=seen)


_MOST_OTHERS = 0.02
"""Share of the cells of a frame that may have another height, as they were misread.

A wrong chunk size puts blocks of all levels on frames, far more than 2 %. With 0 one misread cell hides all frames.
"""


_DECK = 0.9
"""Share of the cells next to a rim that are as high as it from which on it is the rim of a deck, and no frame: of the
examples with frames up to 0.4 are, of decks all but the holes at the rim."""


@dataclass(frozen=True, kw_only=True)
class FrameLayout:
    """The arrangement of frames in a field.

    boundary, side: of a chunk, as in recipes; blocks: along x and y without frames; height: metres.
    """

    boundary: str
    side: int | None
    blocks: Cell
    height: float = 0.0

    @cached_property
    def cells(self) -> Mask:
        """Cells of the field that are frames, (n_x, n_y) with frames."""
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
        """Cells of the field that are frames."""
        return self.field.frame


def frames_of(
    reading: Reading, unit: float, boundary: str | None = None, side: int | None = None
) -> FrameLayout | None:
    """Return the frames of a field, all of whose cells are equally high; None if it has none.

    unit: of heights [m]; boundary, side: to look for, if they are known; else frames around every chunk are tried
    first, from small chunks to large ones, and the rim of a deck is none.
    """
    n_x, n_y = reading.heights.shape
    # A chunk with its frame is two cells wider than its blocks; one chunk alone has an outer frame.
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
        if height is not None and (boundary or share_as_high(reading.heights, frames.cells, height, unit) < _DECK):
            return replace(frames, height=height)
    return None


def share_as_high(heights: Array, rim: Mask, height: float, unit: float) -> float:
    """Return the share of the cells next to a rim that were seen and are as high as it; 0 if none was seen.

    heights: (n_x, n_y) [m], nan where not seen; rim: (n_x, n_y), its cells; height: of the rim [m]
    """
    outer = np.pad(rim, 1)
    beside = ~rim & (outer[:-2, 1:-1] | outer[2:, 1:-1] | outer[1:-1, :-2] | outer[1:-1, 2:])
    own = heights[beside & np.isfinite(heights)]
    return float((np.abs(own - height) < unit / 2).mean()) if len(own) else 0.0


def _height(reading: Reading, unit: float, frame: Mask) -> float | None:
    """Return the common height of the frame cells that were seen [m]; None if they differ, or are the ground."""
    heights = reading.heights[frame & reading.seen]
    if len(heights) < frame.sum() / 2:  # too few to say that the others have the same height
        return None
    height = float(np.median(heights))
    others = np.abs(heights - height) > unit / 2  # of another level; less than a quarter unit high is ground
    return height if height > unit / 4 and others.mean() <= _MOST_OTHERS else None
