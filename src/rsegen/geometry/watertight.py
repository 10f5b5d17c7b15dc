"""Closed meshes of a step field: no gaps, no T-junctions, the volume of its blocks.

`watertight` has few triangles. Every rectangle of the merged surface, and of the bottoms at z = 0, is triangulated with
all corners of others that lie on its sides, so that triangles meet edge to edge; then vertices that are not needed are
decimated by edge collapses that do not change the surface:

     o---x---o          o-------o       x, inside a plane or on a straight edge between two planes, moves onto a
     |       |   -->    |       |       neighbour (in the second case along that edge), if no triangle flips; the
     o-------o          o-------o       two triangles between them disappear

`closed` has many squares and is made in a fraction of the time: nothing is merged, and faces meet on the lattice of all
heights. In both, if two blocks touch only along a vertical edge, each has vertices of its own there, as an edge with
four faces would not be manifold:

      ___            the corner in the middle, seen from above, is `pinched`: it has two vertices, on two sheets;
     |_a_|___        the block on the side of larger y takes the second
         |_b_|

Cost: linear in the corners, and the sorting of fans; decimation takes two fifths of the time. Whole maps only: a tile
of a closed mesh would have walls inside the map (decision 7).
"""

from __future__ import annotations

from math import prod
from typing import NamedTuple

import numpy as np

from rsegen.field.stepfield import Array, Ints, Mask, StepField
from rsegen.geometry.label_grid import LabelGrid, label_grid
from rsegen.geometry.mesh import NORMALS, Faces, Lattice, Mesh, welded
from rsegen.geometry.rectangles import Rectangles, merge, ragged
from rsegen.geometry.surface import risers, tops

_FLAT = 1e-6
"""Share of the smallest initial area below which a triangle counts as degenerate. All areas are multiples of a cell's
or of a step's, so a real triangle is never smaller than that, and rounding errors are far below it."""


class _Fan(NamedTuple):
    """The triangles around each vertex: the vertex, the next two vertices of a triangle, and the triangle's index.

    Sorted by vertex, then by the second vertex.
    """

    vertex: Ints
    second: Ints
    third: Ints
    triangle: Ints


class _Collapses(NamedTuple):
    """Edge collapses: the vertex that is removed, and the one that it is moved onto."""

    vertex: Ints
    target: Ints

    def rows(self, which: Ints | Mask) -> _Collapses:
        return _Collapses(self.vertex[which], self.target[which])


def decimated(faces: Faces, vertices: Array) -> Faces:
    """Return the triangles without removable vertices; faces.corners (m, 3) are indices of vertices (n, 3)."""
    faces = faces._replace(corners=faces.corners.astype(np.int64))
    least = _FLAT * _twice_areas(faces, vertices[faces.corners]).min(initial=np.inf)
    removable = np.ones(len(vertices), dtype=bool)
    while True:
        # Only vertices that were removable in the last round can be so in this one.
        fan = _fan(faces.corners, removable)
        collapses = _collapses(fan, faces, vertices)
        removable[:] = False
        removable[collapses.vertex] = True
        collapses = _independent_collapses(
            _without_flips(collapses, fan, faces, vertices, least), fan, len(faces.corners)
        )
        if not len(collapses.vertex):
            return faces
        place = np.arange(len(vertices))
        place[collapses.vertex] = collapses.target
        corners = place[faces.corners]
        a, b, c = corners.T
        faces = faces._replace(corners=corners).rows(np.flatnonzero((a != b) & (b != c) & (c != a)))


def _fan(corners: Ints, wanted: Mask) -> _Fan:
    """Return the fans of triangles around the wanted vertices."""
    turned = [np.roll(corners, -turn, axis=1)[wanted[corners[:, turn]]] for turn in range(3)]
    triangle = np.concatenate([np.flatnonzero(wanted[corners[:, turn]]) for turn in range(3)])
    vertex, second, third = np.concatenate(turned).T
    order = np.argsort(vertex * len(wanted) + second)
    return _Fan(*(column[order] for column in (vertex, second, third, triangle)))


def _collapses(fan: _Fan, faces: Faces, vertices: Array) -> _Collapses:
    """Return all collapses of removable vertices onto neighbours that keep planes and edges in place.

    An edge of a fan is a crease if the triangles on both sides differ in normal or material. A vertex is removable with
    no creases, or with two along one axis; then only along these.
    """
    count = len(vertices)
    keys = fan.vertex * count + fan.second
    across = fan.triangle[np.searchsorted(keys, fan.vertex * count + fan.third)]
    crease = faces.normals[across] != faces.normals[fan.triangle]
    crease |= faces.materials[across] != faces.materials[fan.triangle]
    creases = np.bincount(fan.vertex[crease], minlength=count)
    axis = np.abs(vertices[fan.third[crease]] - vertices[fan.vertex[crease]]).argmax(axis=1)
    straight = (np.bincount(3 * fan.vertex[crease] + axis, minlength=3 * count).reshape(-1, 3) == 2).any(axis=1)
    free = (creases == 0) | ((creases == 2) & straight)
    may = free[fan.vertex] & (crease | (creases[fan.vertex] == 0))
    return _Collapses(fan.vertex[may], fan.third[may])


def _without_flips(collapses: _Collapses, fan: _Fan, faces: Faces, vertices: Array, least: float) -> _Collapses:
    """Return one collapse per vertex that flips no triangle, if it has one."""
    # Every triangle of a vertex, with the target in its place; triangles that have the target as a corner vanish.
    around = np.bincount(fan.vertex, minlength=len(vertices))
    begin = np.cumsum(around) - around
    count = around[collapses.vertex]
    move, place = ragged(count)
    corner = begin[collapses.vertex[move]] + place
    target, second, third = collapses.target[move], fan.second[corner], fan.third[corner]
    stays = (second != target) & (third != target)
    moved = faces.rows(fan.triangle[corner[stays]])._replace(corners=np.stack([target, second, third], axis=1)[stays])
    over = _twice_areas(moved, vertices[moved.corners]) < least
    good = np.bincount(move[stays][over], minlength=len(count)) == 0
    return collapses.rows(np.flatnonzero(good)[np.unique(collapses.vertex[good], return_index=True)[1]])


def _independent_collapses(collapses: _Collapses, fan: _Fan, triangles: int) -> _Collapses:
    """Return collapses of which no two change the same triangle: of those that do, the one with the smallest hash.

    The hash (Knuth's multiplicative one, 2^32 / golden ratio) mixes neighbouring vertices; with the vertex index itself
    whole rows would wait for their first vertex, and there would be as many rounds as a row has vertices.
    """
    lot = np.full(len(fan.vertex) and int(fan.vertex.max()) + 1, -1)
    lot[collapses.vertex] = collapses.vertex * 2654435761 % 2**32
    mine = lot[fan.vertex]
    first = np.full(triangles, 2**32)
    np.minimum.at(first, fan.triangle[mine >= 0], mine[mine >= 0])
    loses = np.bincount(fan.vertex[(mine >= 0) & (first[fan.triangle] != mine)], minlength=len(lot)) > 0
    return collapses.rows(~loses[collapses.vertex])


def _twice_areas(faces: Faces, corners: Array) -> Array:
    """Return twice the signed area of triangles with corners (m, 3, 3); negative if one has flipped."""
    a, b, c = np.moveaxis(corners, 1, 0)
    return np.asarray((np.cross(b - a, c - a) * NORMALS[faces.normals]).sum(axis=1))


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
    """Return the watertight mesh of a field, in triangles; empty if every cell is at level 0."""
    grid = label_grid(field)
    rings = Faces.joined([tops(grid), bottoms(grid), risers(grid, axis=0), risers(grid, axis=1)])
    triangles, ring = _fans(_outlines(rings, grid))
    points, corners = welded(triangles, 2 * prod(grid.lattice.shape))  # a lattice point has up to two sheets
    faces = rings.rows(ring)._replace(corners=corners)
    faces = decimated(faces, grid.lattice.mesh(faces, points // 2).vertices)
    used, corners = welded(faces.corners, len(points))
    return grid.lattice.mesh(faces._replace(corners=corners), points[used] // 2)


def bottoms(grid: LabelGrid) -> Faces:
    """Return the faces downward at z = 0, split into rectangles; all have the material of the lowest block."""
    rectangles = merge((grid.cells != 0).astype(np.int8))
    ring = grid.lattice.corners_of(rectangles, (0, 1), np.zeros_like(rectangles.u0))[:, ::-1]
    material = (grid.cells[grid.cells != 0] % grid.materials).min(initial=grid.materials)
    return Faces(ring, np.full(len(ring), 5), np.full(len(ring), material))


def _outlines(rings: Faces, grid: LabelGrid) -> _Outlines:
    """Return the rectangles with every corner of others on their sides. A point is 2 * its lattice point + its
    sheet.
    """
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
    """Return the corners of all rectangles along each side, from its first one to before the next, and their number."""
    # Along one axis all corners, sorted by line, are searched for the ends of the sides along it.
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
    """Return a sort key of lattice points, by which points on one line along an axis are consecutive."""
    lines, shape = lattice.unravelled(places), lattice.shape
    first, second = (k for k in range(3) if k != axis)
    return (lines[first] * shape[second] + lines[second]) * shape[axis] + lines[axis]


def _beyond(rings: Faces, lattice: Lattice) -> Mask:
    """Return whether the block of a corner lies on the side of larger y of the corner: (m, 4)."""
    y = lattice.unravelled(rings.corners)[1]
    beyond: Mask = y == y.min(axis=1, keepdims=True)
    beyond[rings.normals == 2] = False
    beyond[rings.normals == 3] = True
    return beyond


def pinched(places: Ints, grid: LabelGrid) -> Mask:
    """Return whether two diagonally opposite blocks touch at a point while the other two are lower."""
    x, y, z = grid.lattice.unravelled(places)
    top = grid.labels // grid.materials
    near_left, near_right, far_left, far_right = (top[x + i, y + j] >= np.maximum(z, 1) for i in (0, 1) for j in (0, 1))
    return np.asarray((near_left == far_right) & (near_right == far_left) & (near_left != near_right))


def _fans(outline: _Outlines) -> tuple[Ints, Ints]:
    """Return the triangles of every rectangle, and the rectangle of each.

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


_FAR = np.array([[1, 0, 0, 1], [1, 0, 0, 1], [0, 0, 0, 0], [1, 1, 1, 1], [1, 1, 0, 0], [0, 0, 1, 1]], dtype=bool)
"""Corners of a face at which its block lies on the side of larger y, for each of NORMALS."""


def closed(field: StepField) -> Mesh:
    """Return the closed mesh of a field, in squares; empty if every cell is at level 0."""
    # Pinched points get a second vertex, at the end of the list, which the faces of the block beyond take.
    grid = label_grid(field)
    faces = Faces.joined([*_tops_and_bottoms(grid), _sides(grid, axis=0), _sides(grid, axis=1)])
    points, corners = welded(faces.corners, prod(grid.lattice.shape))
    doubled = pinched(points, grid)
    second = (len(points) - 1 + np.cumsum(doubled)).astype(corners.dtype)
    own = doubled[corners] & _FAR[faces.normals]
    corners[own] = second[corners[own]]
    return grid.lattice.mesh(faces._replace(corners=corners), np.concatenate([points, points[doubled]]))


def _tops_and_bottoms(grid: LabelGrid) -> tuple[Faces, Faces]:
    """Return a face per cell above the ground at its top, and one at z = 0."""
    x, y = np.nonzero(grid.cells)
    labels = grid.cells[x, y]
    rank, material = np.divmod(labels, grid.materials)
    cells = Rectangles(labels, x, x + 1, y, y + 1)
    top, bottom = (grid.lattice.corners_of(cells, (0, 1), z) for z in (rank, np.zeros_like(rank)))
    return Faces(top, np.full(len(x), 4), material), Faces(bottom[:, ::-1], np.full(len(x), 5), material)


def _sides(grid: LabelGrid, axis: int) -> Faces:
    """Return a face per rank of every side that is seen, along an axis in both directions; u across it, v upward."""
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
