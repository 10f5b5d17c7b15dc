"""The visible surface of a step field: tops and risers, merged and welded, with outward normals.

There are no faces downward and none at z = 0, where the ground is. A riser belongs to the higher of its two cells:

         ____
        |top |      level 2: top at rank 2, riser from rank 1 to 2
    ____|    |____
                    level 1 on both sides

The unmerged mesh: 8 vertices and 6 faces per block, as the paper writes a field; for comparison.
"""

from __future__ import annotations

import numpy as np

from rsegen.field.stepfield import CellWindow, Ints, StepField
from rsegen.geometry.label_grid import LabelGrid, label_grid
from rsegen.geometry.mesh import Faces, Mesh
from rsegen.geometry.rectangles import Rectangles, merge, merge_hanging


def surface(field: StepField, window: CellWindow | None = None) -> Mesh:
    """The surface mesh of a field, or of the cells of a window; empty if all of them are at level 0."""
    grid = label_grid(field, window)
    return grid.lattice.weld(Faces.joined([tops(grid), risers(grid, axis=0), risers(grid, axis=1)]))


def tops(grid: LabelGrid) -> Faces:
    """The horizontal faces; one polygon per connected area of one height and material, split into rectangles."""
    found = merge(grid.cells)
    height, material = np.divmod(found.label, grid.materials)
    return Faces(grid.lattice.corners_of(found, (0, 1), height), np.full(len(material), 4), material)


def risers(grid: LabelGrid, axis: int) -> Faces:
    """The vertical faces with normals along an axis, in both directions; u runs across it, v upward."""
    labels = grid.labels if axis == 0 else grid.labels.T
    strips, sides = _strips(labels[:, 1:-1], grid)
    found = merge_hanging(strips)
    line, side = np.divmod(found.label, sides)
    owner, back = np.divmod(side, 2)
    corners = grid.lattice.corners_of(found, (1 - axis, 2), line)
    inward = (back == 1) == (axis == 0)
    corners[inward] = corners[inward, ::-1]
    return Faces(corners, 2 * axis + back, owner % grid.materials)


def _strips(labels: Ints, grid: LabelGrid) -> tuple[Rectangles, int]:
    """Risers between neighbours along the first array axis, merged if equal, u along the second; and the side count.

    Their label is line * sides + side, and side is 2 * the label of the higher cell, plus 1 if they face backward.
    """
    ranks = len(grid.lattice.lines[2])
    rank = labels // grid.materials
    forward, back = rank[:-1] > rank[1:], rank[:-1] < rank[1:]
    forward[0] = back[-1] = False  # the higher cell is outside the window
    side = np.where(forward, 2 * labels[:-1], np.where(back, 2 * labels[1:] + 1, 0)).astype(np.int64)
    kind = np.where(side != 0, side * ranks + np.minimum(rank[:-1], rank[1:]), 0)
    begins, ends = kind != 0, kind != 0
    apart = kind[:, 1:] != kind[:, :-1]
    begins[:, 1:] &= apart
    ends[:, :-1] &= apart
    starts, stops = np.flatnonzero(begins), np.flatnonzero(ends) + 1
    line, u0 = np.divmod(starts, kind.shape[1])
    side, low = np.divmod(kind.ravel()[starts], ranks)
    sides = 2 * grid.materials * ranks
    top = side // 2 // grid.materials
    return Rectangles(line * sides + side, u0, stops - line * kind.shape[1], low, top), sides


_CORNERS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]])
"""The corners of a unit cube, x, y and z."""

_SIDES = np.array([[1, 2, 6, 5], [3, 0, 4, 7], [2, 3, 7, 6], [0, 1, 5, 4], [4, 5, 6, 7], [3, 2, 1, 0]])
"""The faces of a cube as indices of corners, in the order of NORMALS."""


def unmerged(field: StepField, window: CellWindow | None = None) -> Mesh:
    """The mesh of all blocks and frame cells above the ground, in a field or a window of it; nothing is merged."""
    grid = label_grid(field, window)
    x, y = np.nonzero(grid.cells)
    labels = grid.cells[x, y]
    order = np.argsort(labels % grid.materials, kind="stable")
    cells = np.stack([x, y, np.zeros_like(x)], axis=1)[order]
    scale = np.stack([np.ones_like(x), np.ones_like(x), labels[order] // grid.materials], axis=1)
    count = len(cells)
    return Mesh(
        lines=grid.lattice.lines,
        places=(cells[:, None] + _CORNERS * scale[:, None]).reshape(-1, 3).astype(np.int32),
        faces=(8 * np.arange(count)[:, None, None] + _SIDES).reshape(-1, 4).astype(np.int32),
        normals=np.tile(np.arange(6, dtype=np.int8), count),
        materials=np.repeat(labels[order] % grid.materials, 6).astype(np.int16),
    )
