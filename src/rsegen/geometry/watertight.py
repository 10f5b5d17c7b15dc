"""The watertight surface of a step field: no gaps, no T-junctions, the volume of its blocks.

Every rectangle of the merged surface, and of the bottoms at z = 0, is triangulated with all corners that lie on its
sides, so that triangles meet edge to edge (no T-junctions); removable vertices are then decimated.

If two blocks touch only along a vertical edge, each has vertices of its own there: an edge with four faces would not be
manifold.
"""

from __future__ import annotations

from math import prod
from typing import NamedTuple

import numpy as np

from rsegen.field.stepfield import Ints, Mask, StepField
from rsegen.geometry.chords import ragged
from rsegen.geometry.decimation import decimated
from rsegen.geometry.faces import Faces, Lattice, welded
from rsegen.geometry.label_grid import LabelGrid, label_grid
from rsegen.geometry.mesh import Mesh
from rsegen.geometry.rectangles import merge
from rsegen.geometry.surface import risers, tops


class _Outlines(NamedTuple):
    """Points around rectangles in order: the point, the index of the next, the rectangle (ring), and its side (0..3).

    first: (rings, 4), where the points of each side begin, with a corner of the rectangle.
    """

    point: Ints
    after: Ints
    ring: Ints
    side: Ints
    first: Ints


def watertight(field: StepField) -> Mesh:
    """The watertight mesh of a field, in triangles; empty if every cell is at level 0."""
    grid = label_grid(field)
    rings = Faces.joined([tops(grid), bottoms(grid), risers(grid, axis=0), risers(grid, axis=1)])
    triangles, ring = _fans(_outlines(rings, grid))
    points, corners = welded(triangles, 2 * prod(grid.lattice.shape))
    faces = rings.rows(ring)._replace(corners=corners)
    faces = decimated(faces, grid.lattice.mesh(faces, points // 2).vertices)
    used, corners = welded(faces.corners, len(points))
    return grid.lattice.mesh(faces._replace(corners=corners), points[used] // 2)


def bottoms(grid: LabelGrid) -> Faces:
    """The faces downward at z = 0, one polygon per connected area; all have the material of the lowest block."""
    found = merge((grid.cells != 0).astype(np.int8))
    ring = grid.lattice.corners_of(found, (0, 1), np.zeros_like(found.u0))[:, ::-1]
    material = (grid.cells[grid.cells != 0] % grid.materials).min(initial=grid.materials)
    return Faces(ring, np.full(len(ring), 5), np.full(len(ring), material))


def _outlines(rings: Faces, grid: LabelGrid) -> _Outlines:
    """The rectangles with every corner of others on their sides. A point is 2 * its lattice point + its sheet."""
    corners = rings.corners.astype(np.int64)
    places, count = _between(corners, grid.lattice)
    side = np.repeat(np.arange(corners.size), count)
    first = (np.cumsum(count) - count).reshape(corners.shape)
    after = np.arange(1, len(places) + 1)
    after[first[:, 0][1:] - 1] = first[:, 0][:-1]
    after[-1:] = first[-1:, 0]
    beyond = _beyond(rings, grid.lattice).ravel()[side]
    sheet = beyond & pinched(places, grid)
    return _Outlines(2 * places + sheet, after, side // 4, side % 4, first)


def _between(corners: Ints, lattice: Lattice) -> tuple[Ints, Ints]:
    """The lattice points along each side, from its first corner to before the next one, and their number per side."""
    starts, ends = corners.ravel(), np.roll(corners, -1, axis=1).ravel()
    known = welded(starts, prod(lattice.shape))[0]
    begin, steps = np.zeros((2, len(starts)), dtype=np.int64)
    sorted_along = []
    for axis, n in enumerate(lattice.shape):
        lines = [_key(places, axis, lattice) for places in (known, starts, ends)]
        order = np.argsort(lines[0])
        here = np.flatnonzero(lines[1] // n == lines[2] // n)
        at, until = (np.searchsorted(lines[0][order], line[here]) for line in lines[1:])
        begin[here], steps[here] = at + axis * len(known), until - at
        sorted_along.append(known[order])
    count = np.abs(steps)
    side, offset = ragged(count)
    return np.concatenate(sorted_along)[begin[side] + offset * np.sign(steps)[side]], count


def _key(places: Ints, axis: int, lattice: Lattice) -> Ints:
    """A sort key of lattice points, in which points on one line along an axis are consecutive."""
    lines, shape = lattice.unravelled(places), lattice.shape
    one, other = (k for k in range(3) if k != axis)
    return (lines[one] * shape[other] + lines[other]) * shape[axis] + lines[axis]


def _beyond(rings: Faces, lattice: Lattice) -> Mask:
    """Whether the block of a corner lies on the side of larger y of it: (m, 4)."""
    y = lattice.unravelled(rings.corners)[1]
    found: Mask = y == y.min(axis=1, keepdims=True)
    found[rings.normals == 2] = False
    found[rings.normals == 3] = True
    return found


def pinched(places: Ints, grid: LabelGrid) -> Mask:
    """Whether two diagonally opposite blocks touch at a point while the other two are lower."""
    x, y, z = grid.lattice.unravelled(places)
    top = grid.labels // grid.materials
    near_left, near_right, far_left, far_right = (top[x + i, y + j] >= np.maximum(z, 1) for i in (0, 1) for j in (0, 1))
    return np.asarray((near_left == far_right) & (near_right == far_left) & (near_left != near_right))


def _fans(outline: _Outlines) -> tuple[Ints, Ints]:
    """The triangles of every rectangle, and the rectangle of each.

    c3 ____.____ c2    The edges of each side and one point: on the left the first after c0, on the right the first
      |        |       after c2; below, without the first edge, c3; above, without the first edge, c1.
      |________|
    c0     .    c1
    """
    first = outline.first
    apexes = np.stack([first[:, 3], first[:, 2] + 1, first[:, 1], first[:, 0] + 1], axis=1)
    edges = np.arange(len(outline.point))
    opening = np.zeros(len(edges), dtype=bool)
    opening[first[:, [0, 2]]] = True
    edges = edges[~opening]
    apex = apexes[outline.ring[edges], outline.side[edges]]
    return outline.point[np.stack([edges, outline.after[edges], apex], axis=1)], outline.ring[edges]
