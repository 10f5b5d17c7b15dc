"""The unmerged mesh: 8 vertices and 6 faces per block, as the paper writes a field; for comparison."""

from __future__ import annotations

import numpy as np

from rsegen.field.stepfield import CellWindow, StepField
from rsegen.geometry.label_grid import label_grid
from rsegen.geometry.mesh import Mesh

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
