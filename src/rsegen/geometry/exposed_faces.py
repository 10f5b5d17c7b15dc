"""The visible surface of a step field: tops and risers, merged and welded, with outward normals.

There are no faces downward and none at z = 0, where the ground is. A riser belongs to the higher of its two cells:

         ____
        |top |      level 2: top at rank 2, riser from rank 1 to 2
    ____|    |____
                    level 1 on both sides

Tops are merged per height and material, risers per line and pair of sides, both by rectangles.py. The surface has
T-junctions, where the corner of one rectangle lies on the side of another: for collisions and pictures they do not
matter; for volumes there is the watertight mesh. `unmerged` is the mesh as the paper writes a field, 8 vertices and 6
faces per block, for comparison. Cost: linear in the cells.
"""

from __future__ import annotations

import numpy as np

from rsegen.field.stepfield import CellWindow, Ints, StepField
from rsegen.geometry.mesh import Faces, LabelGrid, Mesh, label_grid
from rsegen.geometry.rectangles import Rectangles, merge, merge_hanging


def surface(field: StepField, window: CellWindow | None = None) -> Mesh:
    """Return the surface mesh of a field, or of the cells of a window; empty if all of them are at level 0."""
    grid = label_grid(field, window)
    return grid.lattice.weld(Faces.joined([tops(grid), risers(grid, axis=0), risers(grid, axis=1)]))


def tops(grid: LabelGrid) -> Faces:
    """Return the horizontal faces; each connected area of one height and material is split into rectangles."""
    rectangles = merge(grid.cells)
    height, material = np.divmod(rectangles.label, grid.materials)
    return Faces(grid.lattice.corners_of(rectangles, (0, 1), height), np.full(len(material), 4), material)


def risers(grid: LabelGrid, axis: int) -> Faces:
    """Return the vertical faces with normals along an axis, in both directions; u runs across it, v upward."""
    labels = grid.labels if axis == 0 else grid.labels.T
    strips, sides = _strips(labels[:, 1:-1], grid)
    rectangles = merge_hanging(strips)
    line, side = np.divmod(rectangles.label, sides)
    owner, back = np.divmod(side, 2)
    corners = grid.lattice.corners_of(rectangles, (1 - axis, 2), line)
    # Corners turn from u to v: along y and z that is counterclockwise for a face to +x, along x and z for one to -y.
    inward = (back == 1) == (axis == 0)
    corners[inward] = corners[inward, ::-1]
    return Faces(corners, 2 * axis + back, owner % grid.materials)


def _strips(labels: Ints, grid: LabelGrid) -> tuple[Rectangles, int]:
    """Return the risers between neighbours along the first array axis, equal ones merged; and the number of sides.

    u is along the second axis. A label is line * sides + side, and side is 2 * the label of the higher cell, plus 1 if
    they face backward.
    """
    ranks = len(grid.lattice.lines[2])
    rank = labels // grid.materials
    forward, back = rank[:-1] > rank[1:], rank[:-1] < rank[1:]
    forward[0] = back[-1] = False  # the higher cell is outside the window
    side = np.where(forward, 2 * labels[:-1], np.where(back, 2 * labels[1:] + 1, 0)).astype(np.int64)
    kind = np.where(side != 0, side * ranks + np.minimum(rank[:-1], rank[1:]), 0)
    # A strip goes on as long as side and lower rank are the same; both are in `kind`.
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
    """Return the mesh of all blocks and frame cells above the ground, in a field or a window; nothing is merged."""
    # A cube per cell, stretched to its height.
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
