"""Few boxes that fill a step field exactly and do not overlap.

Two partitions, of which the smaller one counts; both cut rectangles of one height (rectangles.py):

     columns: a box from the ground to each height      layers: a box from one height to the next, joined upward

         _                                                  _
       _| |_      3 boxes                                 _|_|_     2 boxes
      | | | |                                            |_____|

Which one is smaller depends on the map; on random maps they differ by some per cent. Neither is the least possible
number, which is hard to find in three dimensions (NP-complete: Dielissen and Kaldewaij 1991). Cost: one partition into
rectangles (rectangles.py) per height.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from rsegen.errors import refuse_other
from rsegen.field.stepfield import Array, Ints, StepField, make_read_only, read_only_copies
from rsegen.geometry.mesh import LabelGrid, label_grid
from rsegen.geometry.rectangles import merge


@read_only_copies
@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Boxes:
    """Axis-aligned boxes.

    Attributes
    ----------
    low, high : ndarray, shape (n, 3)
        Their corners of the smallest and the largest x, y and z, metres.
    """

    low: Array
    high: Array

    def __post_init__(self) -> None:
        make_read_only(self.low, self.high)

    def __len__(self) -> int:
        return len(self.low)

    @property
    def centres(self) -> Array:
        """Centre of each box, (n, 3), metres."""
        return (self.low + self.high) / 2

    @property
    def sizes(self) -> Array:
        """Side lengths of each box along x, y and z, (n, 3), metres."""
        return self.high - self.low


class Column(NamedTuple):
    """A box on the ground: its centre and its size along x, y and z, metres, and its material."""

    centre: tuple[float, float, float]
    size: tuple[float, float, float]
    material: int


def boxes(field: StepField) -> Boxes:
    """Return few boxes that together fill the blocks and frames of a field, regardless of materials.

    Either each box stands on the ground and its top is a rectangle of one height; or the boxes lie in layers, from one
    height to the next: whichever needs fewer boxes.

    Parameters
    ----------
    field : StepField
        The blocks and frames.

    Returns
    -------
    Boxes
        The boxes, metres.
    """
    refuse_other("field", field, StepField)
    grid = label_grid(field)
    tops = merge(grid.cells // grid.materials)
    from_ground = np.stack([tops.u0, tops.u1, tops.v0, tops.v1, 0 * tops.u0, tops.label], axis=1)
    return _placed(min(from_ground, _layers(grid), key=len), grid)


def box_per_block(field: StepField) -> Boxes:
    """Return a box per cell above the ground."""
    grid = label_grid(field)
    x, y = np.nonzero(grid.cells)
    return _placed(np.stack([x, x + 1, y, y + 1, 0 * x, grid.cells[x, y] // grid.materials], axis=1), grid)


def columns(field: StepField) -> Iterator[Column]:
    """Yield few boxes, each of one material, that fill the blocks and frames of a field and do not overlap."""
    grid = label_grid(field)
    rectangles = merge(grid.cells)
    rank, material = np.divmod(rectangles.label, grid.materials)
    x, y, z = grid.lattice.lines
    low = np.stack([x[rectangles.u0], y[rectangles.v0], np.zeros(len(rank))], axis=1)
    high = np.stack([x[rectangles.u1], y[rectangles.v1], z[rank]], axis=1)
    rows = zip(((low + high) / 2).tolist(), (high - low).tolist(), material.tolist(), strict=True)
    return (Column(tuple(centre), tuple(size), kind) for centre, size, kind in rows)


def _layers(grid: LabelGrid) -> Ints:
    """Return boxes in layers as lattice lines (n, 6), from and to along x, y and z; equal ones in a pile are one."""
    top = grid.cells // grid.materials
    layers = []
    for rank in range(1, len(grid.lattice.lines[2])):
        layer = merge((top >= rank).astype(np.int8))
        layers.append(np.stack([layer.u0, layer.u1, layer.v0, layer.v1, np.full_like(layer.u0, rank)], axis=1))
    lines = np.concatenate([np.empty((0, 5), dtype=np.int64), *layers])
    # Sorted by rectangle and then by rank, the layers of one box follow one another.
    lines = lines[np.lexsort(lines.T[::-1])]
    begins = np.ones(len(lines) + 1, dtype=bool)
    begins[1:-1] = (np.diff(lines, axis=0) != [0, 0, 0, 0, 1]).any(axis=1)
    first, last = lines[begins[:-1]], lines[begins[1:], 4:]
    return np.concatenate([first[:, :4], first[:, 4:] - 1, last], axis=1)


def _placed(lines: Ints, grid: LabelGrid) -> Boxes:
    """Return the boxes of lattice lines (n, 6) in metres."""
    low, high = (
        np.stack([line[lines[:, 2 * axis + end]] for axis, line in enumerate(grid.lattice.lines)], axis=1)
        for end in (0, 1)
    )
    return Boxes(low=low, high=high)
