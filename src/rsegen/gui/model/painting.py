"""Cells painted by hand: the cells of a stroke, and the matrix obstacle that they become."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rsegen.errors import ParameterError
from rsegen.field.obstacles.matrix import Matrix
from rsegen.field.stepfield import Ints, Mask
from rsegen.gui.model.session import Entry
from rsegen.params.places import Cell
from rsegen.params.sorts import Json
from rsegen.recipe.codec import decode_placement

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
    """Whether an entry is a matrix in its own size at a fixed place, so that cells can be painted into it."""
    try:
        placement = decode_placement(entry)
    except ParameterError:
        return False
    matrix = placement.obstacle
    if not isinstance(matrix, Matrix) or matrix.softness or "random" in (placement.first or ()):
        return False
    start = placement.first or (0, 0)
    own = tuple(at + size - 1 for at, size in zip(start, matrix.size, strict=True))  # type: ignore[operator]  # a cell
    return placement.last in (None, own)


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
        "max_height": max(matrix.max_height, entry["max_height"] if entry else 2),
        "rows": list(matrix.rows),
        "first": list(first),
        "last": [at + size - 1 for at, size in zip(first, matrix.size, strict=True)],
    }


def _grown(entry: Entry | None, cells: Sequence[Cell]) -> tuple[Cell, Ints]:
    """The corner of smallest x and y, and the levels from there on, of the entry grown to include the cells."""
    corners = [*cells]
    if entry:
        old = decode_placement(entry)
        levels = old.obstacle.levels()  # type: ignore[attr-defined]  # a matrix
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
