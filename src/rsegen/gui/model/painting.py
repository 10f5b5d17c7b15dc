"""Cells painted by hand: strokes of the tools, the cell under a click, and the matrix obstacle that they become."""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum
from typing import NamedTuple

import numpy as np

from rsegen.errors import ParameterError
from rsegen.field.obstacles.matrix import Matrix
from rsegen.field.stepfield import Array, CellWindow, Ints, Levels, Mask, StepField
from rsegen.gui.model.session import Entry
from rsegen.params.sorts import Cell, Json
from rsegen.recipe.codec import decode_obstacle

UNPAINTED = -1
"""The level that erases a cell."""


def stroke(start: Cell, stop: Cell) -> tuple[Cell, ...]:
    """The cells on the line from one cell to another, both included, without a gap."""
    steps = max(abs(stop[0] - start[0]), abs(stop[1] - start[1]), 1)
    along = np.arange(steps + 1)
    x, y = ((a * (steps - along) * 2 + b * along * 2 + steps) // (2 * steps) for a, b in zip(start, stop, strict=True))
    return tuple(dict.fromkeys(zip(x.tolist(), y.tolist(), strict=True)))


def next_cell(cell: Cell, cells: Cell) -> Cell:
    """The next cell in reading order: to the right, then from the left of the row below, then from the top."""
    x, y = cell
    if x + 1 < cells[0]:
        return x + 1, y
    return (0, y - 1) if y else (0, cells[1] - 1)


def can_paint(entry: Entry) -> bool:
    """Return whether an entry is a matrix in its own size at a fixed place, so that cells can be painted into it."""
    try:
        matrix = decode_obstacle(entry)
    except ParameterError:
        return False
    if not isinstance(matrix, Matrix) or matrix.softness or "random" in (matrix.first or ()):
        return False
    start = matrix.first or (0, 0)
    own = tuple(at + size - 1 for at, size in zip(start, matrix.size, strict=True))  # type: ignore[operator]  # a cell
    return matrix.last in (None, own)


def painted(entry: Entry | None, cells: Sequence[Cell], level: int) -> dict[str, Json]:
    """A matrix entry, or a new one, with some cells set to a level; it grows as needed."""
    start, levels = _grown(entry, cells)
    for x, y in cells:
        levels[x - start[0], y - start[1]] = level
    (x1, x2), (y1, y2) = (_span(levels >= 0, axis) for axis in (0, 1))
    matrix = Matrix.of(levels[x1:x2, y1:y2])
    first = start[0] + x1, start[1] + y1
    return {
        **(entry or {"kind": Matrix.kind}),
        "levels": max(matrix.levels, entry.get("levels", 2) if entry else 2),
        "rows": list(matrix.rows),
        "first": list(first),
        "last": [at + size - 1 for at, size in zip(first, matrix.size, strict=True)],
    }


def _grown(entry: Entry | None, cells: Sequence[Cell]) -> tuple[Cell, Ints]:
    """The corner of smallest x and y, and the levels from there on, of the entry grown to include the cells."""
    corners = [*cells]
    if entry:
        old = decode_obstacle(entry)
        levels = old.cell_levels()  # type: ignore[attr-defined]  # a matrix
        x, y = entry.get("first", (0, 0))
        corners += [(x, y), (x + levels.shape[0] - 1, y + levels.shape[1] - 1)]
    low, high = np.min(corners, axis=0), np.max(corners, axis=0)
    grown = np.full(high - low + 1, UNPAINTED)
    if entry:
        grown[x - low[0] : x - low[0] + levels.shape[0], y - low[1] : y - low[1] + levels.shape[1]] = levels
    return (int(low[0]), int(low[1])), grown


def _span(covered: Mask, axis: int) -> tuple[int, int]:
    """The range of painted cells along an axis; the first cell if none is painted."""
    there = np.flatnonzero(covered.any(axis=1 - axis))
    return (int(there[0]), int(there[-1]) + 1) if len(there) else (0, 1)


class Tool(Enum):
    """How cells are painted."""

    CELLS = "cells"
    RECTANGLE = "rectangle"
    FILL = "fill"
    PICK = "pick"


class Brush(NamedTuple):
    """A tool and the level that it paints."""

    tool: Tool
    level: int


class Painted(NamedTuple):
    """Cells, their new level (UNPAINTED to erase), and the number of the stroke."""

    cells: Sequence[Cell]
    level: int
    stroke: int


class Strokes:
    """The stroke that is being painted, if any, and the cell that the keyboard paints.

    band: the corners of the rectangle that is being drawn.
    """

    def __init__(self) -> None:
        self.cursor: Cell = (0, 0)
        self.band: tuple[Cell, Cell] | None = None
        self._level: int | None = None
        self._tool = Tool.CELLS
        self._count = 0

    @property
    def is_going_on(self) -> bool:
        """Return whether the mouse is painting."""
        return self._level is not None

    def begin(self, brush: Brush, cell: Cell, levels: Levels, *, erases: bool) -> Painted | None:
        """Start a stroke at a cell; gives what it paints at once. `levels`: those of all blocks, for filling."""
        self._tool, self._level = brush.tool, UNPAINTED if erases else brush.level
        self._count += 1
        self.cursor = cell
        if brush.tool is Tool.RECTANGLE:
            self.band = cell, cell
            return None
        return self._painted(connected(levels, cell) if brush.tool is Tool.FILL else (cell,))

    def go_to(self, cell: Cell) -> Painted | None:
        """Continue the stroke to another cell; gives what that paints, without a gap."""
        if self._level is None or cell == self.cursor:
            return None
        before, self.cursor = self.cursor, cell
        if self.band:
            self.band = self.band[0], cell
        return self._painted(stroke(before, cell)) if self._tool is Tool.CELLS else None

    def end(self) -> Painted | None:
        """End the stroke; gives what that paints: a rectangle."""
        found = self._painted(rectangle(*self.band)) if self.band else None
        self.cancel()
        return found

    def cancel(self) -> None:
        """End the stroke without painting more."""
        self._level = self.band = None

    def paint_here(self, level: int) -> Painted:
        """Give the cell of the keyboard a level, as a stroke of its own."""
        self._count += 1
        return Painted((self.cursor,), level, self._count)

    def _painted(self, cells: Sequence[Cell]) -> Painted | None:
        return None if self._level is None else Painted(tuple(cells), self._level, self._count)


def rectangle(one: Cell, other: Cell) -> tuple[Cell, ...]:
    """The cells between two corners, both included."""
    (x1, x2), (y1, y2) = (sorted(pair) for pair in zip(one, other, strict=True))
    return tuple((x, y) for x in range(x1, x2 + 1) for y in range(y1, y2 + 1))


def connected(levels: Levels, start: Cell) -> tuple[Cell, ...]:
    """The cells of the level of one that it is connected with by sides, itself included."""
    free = np.pad(levels == levels[start], 1)
    free[start[0] + 1, start[1] + 1] = False
    found, edge = [start], [start]
    while edge:
        x, y = edge.pop()
        for at in ((x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)):
            if free[at[0] + 1, at[1] + 1]:
                free[at[0] + 1, at[1] + 1] = False
                found.append(at)
                edge.append(at)
    return tuple(found)


def cell_hit(field: StepField, start: Array, stop: Array) -> Cell | None:
    """The field cell whose top or side a ray between two points [m] meets first; None if it meets none.

    Between two lines of the grid the ray is over one cell, and meets it if its lower end there is below the top.
    """
    along = stop - start
    shares = [np.array([0.0, 1.0])]
    for axis, edges in enumerate(field.edges()):
        if along[axis]:
            shares.append((edges - start[axis]) / along[axis])
    at = np.unique(np.clip(np.concatenate(shares), 0, 1))
    middles = start[None, :2] + (at[:-1] + at[1:])[:, None] / 2 * along[:2]
    lowest = np.minimum(start[2] + at[:-1] * along[2], start[2] + at[1:] * along[2])
    i, j = np.floor((middles + np.array(field.extent) / 2) / field.block_width).astype(int).T
    (over,) = np.nonzero((i >= 0) & (i < field.shape[0]) & (j >= 0) & (j < field.shape[1]))
    met = over[lowest[over] <= field.heights[i[over], j[over]]]
    return (int(i[met[0]]), int(j[met[0]])) if len(met) else None


def is_inside(cell: Cell, window: CellWindow | None) -> bool:
    """Return whether a field cell is in a window; in none if there is no window."""
    return window is not None and all(part.start <= at < part.stop for at, part in zip(cell, window, strict=True))
