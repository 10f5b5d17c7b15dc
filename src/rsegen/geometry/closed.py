"""A closed mesh of squares: every block has a top and a bottom, and a face for each rank of a side that is seen.

Nothing is merged, so it is made quickly and has no T-junctions: faces meet edge to edge on the lattice of all heights.
Where two blocks touch only along a vertical edge, each has vertices of its own there, as in the watertight mesh.
"""

from __future__ import annotations

from math import prod

import numpy as np

from rsegen.field.stepfield import Ints, StepField
from rsegen.geometry.chords import ragged
from rsegen.geometry.faces import Faces, welded
from rsegen.geometry.label_grid import LabelGrid, label_grid
from rsegen.geometry.mesh import Mesh
from rsegen.geometry.rectangles import Rectangles
from rsegen.geometry.watertight import pinched

_FAR = np.array([[1, 0, 0, 1], [1, 0, 0, 1], [0, 0, 0, 0], [1, 1, 1, 1], [1, 1, 0, 0], [0, 0, 1, 1]], dtype=bool)
"""For each of NORMALS, at which corners of a face its block lies on the side of larger y."""


def closed(field: StepField) -> Mesh:
    """The closed mesh of a field, in squares; empty if every cell is at level 0."""
    grid = label_grid(field)
    faces = Faces.joined([*_tops_and_bottoms(grid), _sides(grid, axis=0), _sides(grid, axis=1)])
    points, corners = welded(faces.corners, prod(grid.lattice.shape))
    doubled = pinched(points, grid)
    second = (len(points) - 1 + np.cumsum(doubled)).astype(corners.dtype)
    own = doubled[corners] & _FAR[faces.normals]
    corners[own] = second[corners[own]]
    return grid.lattice.mesh(faces._replace(corners=corners), np.concatenate([points, points[doubled]]))


def _tops_and_bottoms(grid: LabelGrid) -> tuple[Faces, Faces]:
    x, y = np.nonzero(grid.cells)
    labels = grid.cells[x, y]
    rank, material = np.divmod(labels, grid.materials)
    cells = Rectangles(labels, x, x + 1, y, y + 1)
    top, bottom = (grid.lattice.corners_of(cells, (0, 1), z) for z in (rank, np.zeros_like(rank)))
    return Faces(top, np.full(len(x), 4), material), Faces(bottom[:, ::-1], np.full(len(x), 5), material)


def _sides(grid: LabelGrid, axis: int) -> Faces:
    """The faces with normals along an axis, in both directions; u runs across it, v upward."""
    labels = (grid.labels if axis == 0 else grid.labels.T)[:, 1:-1]
    rank = labels // grid.materials
    line, u = np.nonzero(rank[:-1] != rank[1:])
    near, far = rank[line, u], rank[line + 1, u]
    low, height = np.minimum(near, far), np.abs(near - far)
    face, offset = ragged(height)
    line, u, v, back = line[face], u[face], low[face] + offset, (far > near)[face]
    owner = labels[line + back, u]
    corners = grid.lattice.corners_of(Rectangles(owner, u, u + 1, v, v + 1), (1 - axis, 2), line)
    inward: Ints = back == (axis == 0)
    corners[inward] = corners[inward, ::-1]
    return Faces(corners, 2 * axis + back, owner % grid.materials)
