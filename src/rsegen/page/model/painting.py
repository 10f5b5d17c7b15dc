"""Cells painted by hand, and the matrix obstacle that they become."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rsegen.errors import ParameterError
from rsegen.field.obstacles.matrix import Matrix
from rsegen.field.stepfield import Ints, Mask
from rsegen.page.model.session import Entry
from rsegen.params.sorts import Cell, Json
from rsegen.recipe.codec import decode_obstacle

UNPAINTED = -1
"""The level that erases a cell."""


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
    """Return a matrix entry, or a new one, with some cells set to a level; it grows as needed."""
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
    """Return the corner of smallest x and y, and the levels from there on, of the entry grown to include the cells."""
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
    """Return the range of painted cells along an axis; the first cell if none is painted."""
    there = np.flatnonzero(covered.any(axis=1 - axis))
    return (int(there[0]), int(there[-1]) + 1) if len(there) else (0, 1)
