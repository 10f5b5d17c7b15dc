"""A step field as few boxes, which fill it exactly and do not overlap."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rsegen.field.stepfield import Array, Ints, StepField
from rsegen.geometry.label_grid import LabelGrid, label_grid
from rsegen.geometry.rectangles import merge


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Boxes:
    """Axis-aligned boxes as their low and their high corners, (n, 3) each, metres."""

    low: Array
    high: Array

    def __len__(self) -> int:
        return len(self.low)

    @property
    def centres(self) -> Array:
        """The centre of each box, (n, 3), metres."""
        return (self.low + self.high) / 2

    @property
    def sizes(self) -> Array:
        """The side lengths of each box along x, y and z, (n, 3), metres."""
        return self.high - self.low


def boxes(field: StepField) -> Boxes:
    """Few boxes that together fill the blocks and frames of a field, regardless of materials.

    Either each box stands on the ground and its top is a rectangle of one height; or the boxes lie in layers, from one
    height to the next: whichever needs fewer boxes.
    """
    grid = label_grid(field)
    return _placed(min(_columns(grid), _layers(grid), key=len), grid)


def box_per_block(field: StepField) -> Boxes:
    """One box per cell above the ground."""
    grid = label_grid(field)
    x, y = np.nonzero(grid.cells)
    return _placed(np.stack([x, x + 1, y, y + 1, 0 * x, grid.cells[x, y] // grid.materials], axis=1), grid)


def _columns(grid: LabelGrid) -> Ints:
    """Boxes from the ground up, as lattice lines (n, 6): from and to along x, y and z."""
    found = merge(grid.cells // grid.materials)
    return np.stack([found.u0, found.u1, found.v0, found.v1, 0 * found.u0, found.label], axis=1)


def _layers(grid: LabelGrid) -> Ints:
    """Boxes in layers, as lattice lines (n, 6); equal rectangles in successive layers become one box."""
    top = grid.cells // grid.materials
    found = []
    for rank in range(1, len(grid.lattice.lines[2])):
        layer = merge((top >= rank).astype(np.int8))
        found.append(np.stack([layer.u0, layer.u1, layer.v0, layer.v1, np.full_like(layer.u0, rank)], axis=1))
    lines = np.concatenate([np.empty((0, 5), dtype=np.int64), *found])
    lines = lines[np.lexsort(lines.T[::-1])]
    begins = np.ones(len(lines) + 1, dtype=bool)
    begins[1:-1] = (np.diff(lines, axis=0) != [0, 0, 0, 0, 1]).any(axis=1)
    first, last = lines[begins[:-1]], lines[begins[1:], 4:]
    return np.concatenate([first[:, :4], first[:, 4:] - 1, last], axis=1)


def _placed(lines: Ints, grid: LabelGrid) -> Boxes:
    low, high = (
        np.stack([line[lines[:, 2 * axis + end]] for axis, line in enumerate(grid.lattice.lines)], axis=1)
        for end in (0, 1)
    )
    return Boxes(low=low, high=high)
