"""A step field: integer levels in cells, some of which are frame cells.

Heights are integers in units, so equality is exact; metres appear only in `heights`. Arrays have shape (n_x, n_y):
axis 0 along +x, axis 1 along +y, cell (0, 0) in the corner of smallest x and y, the field centred on the origin.

     blocks (2 x 3)   --framed, outer-->   # # # # #      #: frame cells, levels 0 and frame true
      . . .                                # . . . #
      . . .                                # . . . #
                                           # # # # #

A large map is drawn as a `coarse` one, in which each cell has the level and material of the highest of several.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, ClassVar, TypeVar

import numpy as np
from numpy.typing import NDArray

from rsegen.errors import ParameterError, shown
from rsegen.params.sorts import NANOMETRE_DIGITS, Float

Levels = NDArray[np.int16]
Mask = NDArray[np.bool_]
Array = NDArray[np.float64]
Ints = NDArray[np.integer]

CellWindow = tuple[slice, slice]
"""A rectangle of cells of a field as slices along x and y, frames counted."""

_Kind = TypeVar("_Kind")

NO_CAP = 2**30
"""A level above all levels, for cells without a limit; twice it still fits into 32 bits."""


def make_read_only(*arrays: NDArray[Any]) -> None:
    """Let nobody write into the arrays of a frozen value."""
    for array in arrays:
        array.setflags(write=False)


def read_only_copies(kind: type[_Kind]) -> type[_Kind]:
    """Keep the arrays of a frozen dataclass read-only in its pickles and deep copies, which numpy does not.

    A decorator above `@dataclass`, which in Python 3.11.2 puts its own `__setstate__` in the place of any other.
    """
    kind.__setstate__ = _restore  # type: ignore[attr-defined]  # of pickle, by name
    return kind


def _restore(instance: Any, state: Any) -> None:
    """Set the fields of a frozen value, its arrays read-only; state: the fields in their order, or values by name."""
    names = [field.name for field in fields(instance)]
    by_name = state if isinstance(state, dict) else dict(zip(names, state, strict=True))
    for name, value in by_name.items():
        parts = value if isinstance(value, tuple) else (value,)
        make_read_only(*(part for part in parts if isinstance(part, np.ndarray)))
        object.__setattr__(instance, name, value)


_LENGTHS = {"block_width": Float(1e-9, unit="m"), "unit": Float(1e-9, unit="m"), "frame_height": Float(0, unit="m")}
"""Lengths of a field: nanometres at least, to which lengths are rounded, or no frame at all."""


@read_only_copies
@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class StepField:
    """The blocks and frames of one map, or of a part of it.

    Parameters
    ----------
    levels : ndarray of int16, shape (n_x, n_y)
        Height of each block in units, 0 in frame cells.
    frame : ndarray of bool, shape (n_x, n_y)
        True for frame cells.
    block_width : float
        Side of a block, metres.
    unit : float
        Height of a level, metres.
    frame_height : float
        Height of the frames, metres.

    Raises
    ------
    ParameterError
        If a value is of another type or shape, or negative.
    """

    levels: Levels
    frame: Mask
    block_width: float
    unit: float
    frame_height: float

    def __post_init__(self) -> None:
        levels, frame = self.levels, self.frame
        is_grid = isinstance(levels, np.ndarray) and levels.dtype.kind in "iu" and levels.ndim == 2 and levels.size
        if not is_grid or levels.min() < 0:
            raise ParameterError("levels", f"{shown(levels)} is not an array (n_x, n_y) of whole numbers from 0 on")
        if not isinstance(frame, np.ndarray) or frame.dtype != bool or frame.shape != levels.shape:
            raise ParameterError("frame", f"{shown(frame)} is not an array of bool of shape {levels.shape}, as levels")
        for name, length in _LENGTHS.items():
            length.check(name, getattr(self, name))
        make_read_only(levels, frame)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, StepField):
            return NotImplemented
        lengths = (self.block_width, self.unit, self.frame_height)
        return (
            lengths == (other.block_width, other.unit, other.frame_height)
            and np.array_equal(self.levels, other.levels)
            and np.array_equal(self.frame, other.frame)
        )

    __hash__: ClassVar[None] = None  # type: ignore[assignment]  # compares by its arrays

    @property
    def shape(self) -> tuple[int, int]:
        """Cells along x and y, frames included."""
        return self.levels.shape[0], self.levels.shape[1]

    @property
    def whole(self) -> CellWindow:
        """The window of all cells."""
        return slice(0, self.shape[0]), slice(0, self.shape[1])

    def is_raised(self, window: CellWindow | None = None) -> bool:
        """Return whether anything in the field, or in a window of it, is above the ground."""
        part = window or self.whole
        return bool(self.levels[part].any()) or self._frame_is_raised(part)

    def materials(self, window: CellWindow | None = None) -> list[int]:
        """Return the materials above the ground in the field or a window: 0 for frames, else the level of blocks."""
        part = window or self.whole
        levels = np.flatnonzero(np.bincount(self.levels[part].ravel())).tolist()
        return [0] * self._frame_is_raised(part) + [int(level) for level in levels if level]

    def only(self, materials: Sequence[int]) -> StepField:
        """Return the field with only these materials; the cells of all others become level ground."""
        is_wanted = np.isin(self.levels, materials)
        frame = self.frame if 0 in materials else np.zeros_like(self.frame)
        return replace(self, levels=np.where(is_wanted, self.levels, np.int16(0)), frame=frame)

    @property
    def extent(self) -> tuple[float, float]:
        """Metres along x and y, frames included."""
        n_x, n_y = self.shape
        return round(n_x * self.block_width, NANOMETRE_DIGITS), round(n_y * self.block_width, NANOMETRE_DIGITS)

    @property
    def heights(self) -> Array:
        """Height of every cell's top above the ground, metres, shape (n_x, n_y)."""
        heights = np.where(self.frame, self.frame_height, self.levels.astype(np.float64) * self.unit)
        return np.asarray(np.round(heights, NANOMETRE_DIGITS))

    @property
    def blocks(self) -> Levels:
        """Levels without the frame cells, as one array of blocks."""
        return self.levels[np.ix_(self.inside(0), self.inside(1))]

    def inside(self, axis: int) -> Mask:
        """Return per index along an axis (0: x, 1: y) whether that line has blocks; false if it is all frame."""
        return np.asarray(~self.frame.all(axis=1 - axis))

    def numbered(self, axis: int) -> Ints:
        """Return per index along an axis the index of that line of blocks in recipes, -1 if it is all frame."""
        inside = self.inside(axis)
        return np.where(inside, np.cumsum(inside) - 1, -1)

    def edges(self) -> tuple[Array, Array]:
        """Return the coordinates of the cell edges, metres: x of shape (n_x + 1,) and y of shape (n_y + 1,)."""
        x, y = ((np.arange(cells + 1) - cells / 2) * self.block_width for cells in self.shape)
        return np.round(x, NANOMETRE_DIGITS), np.round(y, NANOMETRE_DIGITS)

    def middles(self) -> tuple[Array, Array]:
        """Return the coordinates of the middles of cells, metres: x of shape (n_x,) and y of shape (n_y,)."""
        x, y = ((line[:-1] + line[1:]) / 2 for line in self.edges())
        return x, y

    def level_counts(self) -> dict[int, int]:
        """Return the number of blocks of each level, without frames; lowest level first."""
        counts = np.bincount(self.levels[~self.frame])
        return {int(level): int(counts[level]) for level in np.flatnonzero(counts)}

    def chunks(self, chunk_size: int) -> Iterator[Chunk]:
        """Yield the chunks of the field, each with its adjacent frame cells."""
        cuts_x, cuts_y = (_cuts(self.inside(axis), chunk_size) for axis in (0, 1))
        middle_x, middle_y = ((cuts[1:] + cuts[:-1] - cuts[-1]) / 2 * self.block_width for cuts in (cuts_x, cuts_y))
        for i, x in enumerate(middle_x):
            for j, y in enumerate(middle_y):
                part = slice(cuts_x[i], cuts_x[i + 1]), slice(cuts_y[j], cuts_y[j + 1])
                field = replace(self, levels=self.levels[part], frame=self.frame[part])
                yield Chunk(index=(i, j), centre=(float(x), float(y)), field=field)

    def _frame_is_raised(self, part: CellWindow) -> bool:
        return bool(round(self.frame_height, NANOMETRE_DIGITS) and self.frame[part].any())


@dataclass(frozen=True, kw_only=True, slots=True)
class Chunk:
    """A chunk of a map as its own field, with its indices along x and y and its centre in metres."""

    index: tuple[int, int]
    centre: tuple[float, float]
    field: StepField


def framed(blocks: Levels, chunk_size: int, boundary: str) -> tuple[Levels, Mask]:
    """Return levels and frame mask of the whole map, from its blocks of shape (M_x * L, M_y * L).

    `divided` puts a frame round every chunk, `outer` one round the map, `none` none; a frame is one cell deep.
    """
    if boundary == "none":
        return blocks, np.zeros(blocks.shape, dtype=bool)
    period = chunk_size if boundary == "divided" else max(blocks.shape)
    inside_x, inside_y = (_inside(cells, period) for cells in blocks.shape)
    frame = ~(inside_x[:, None] & inside_y[None, :])
    levels = np.zeros(frame.shape, dtype=np.int16)
    levels[np.ix_(inside_x, inside_y)] = blocks
    return levels, frame


def _inside(cells: int, period: int) -> Mask:
    """Return per index along an axis: true for blocks, false for the frame before and after every `period` blocks."""
    period = min(cells, period)
    return np.tile(np.array([False, *[True] * period, False]), cells // period)


def _cuts(inside: Mask, chunk_size: int) -> NDArray[np.intp]:
    """Return the indices that split an axis into chunks: after every `chunk_size` blocks and any frame cell of them."""
    ends = np.flatnonzero(inside)[chunk_size - 1 :: chunk_size] + 1
    last = len(inside)
    # Divided chunks have two frame cells between them, one of each; an outer frame goes to the first and last chunk.
    framed_between = len(ends) > 1 and not inside[min(ends[0], last - 1)]
    cuts = ends + 1 if framed_between else ends.copy()
    cuts[-1] = last
    return np.concatenate([[0], cuts])


def coarseness(field: StepField, most: int) -> int:
    """Return the downsampling factor per side that gives at most about `most` x `most` cells."""
    n_x, n_y = field.shape
    return max(min(math.ceil(math.sqrt(n_x * n_y) / most), n_x, n_y), 1)


def coarse(field: StepField, factor: int) -> StepField:
    """Return the field in cells `factor` times as wide, each the highest of the cells under it; a rest is cut off."""
    if factor == 1:
        return field
    i, j = coarse_indices(field, factor)
    block_width = field.block_width * factor
    return replace(field, levels=field.levels[i, j], frame=field.frame[i, j], block_width=block_width)


def coarse_indices(field: StepField, factor: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the indices of the highest of every `factor` x `factor` cells."""
    n_x, n_y = (cells // factor for cells in field.shape)
    parts = field.heights[: n_x * factor, : n_y * factor].reshape(n_x, factor, n_y, factor)
    within = parts.transpose(0, 2, 1, 3).reshape(n_x, n_y, -1).argmax(axis=-1)
    return np.arange(n_x)[:, None] * factor + within // factor, np.arange(n_y)[None, :] * factor + within % factor
