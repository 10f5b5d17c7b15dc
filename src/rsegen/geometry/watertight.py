"""The closed mesh of a step field: no gaps, no T-junctions, the volume of its blocks, few triangles.

Every rectangle of the merged surface, and of the bottoms at z = 0, is triangulated with all corners of others that lie
on its sides, so that triangles meet edge to edge; then vertices that are not needed are decimated by edge collapses
that do not change the surface:

     o---x---o          o-------o       x, inside a plane or on a straight edge between two planes, moves onto a
     |       |   -->    |       |       neighbour (in the second case along that edge), if no triangle flips; the
     o-------o          o-------o       two triangles between them disappear

Which vertices those are is known before there is a triangle, from the labels of the four cells around each (`_ways`):
on random maps one in ten, so only one triangle in five takes part in the rounds of collapses. A vertex that could not
move is tried again when one of its triangles has changed.

If two blocks touch only along a vertical edge, each has vertices of its own there, as an edge with four faces would not
be manifold:

      ___            the corner in the middle, seen from above, is `pinched`: it has two vertices, on two sheets;
     |_a_|___        the block on the side of larger y takes the second
         |_b_|

Cost: linear in the corners, and the sorting of fans; about six times the merged surface, of which triangulation and
decimation take a third each. Whole maps only: a tile of a closed mesh would have walls inside the map (decision 7).
"""

from __future__ import annotations

from collections.abc import Sequence
from math import prod
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rsegen.field.stepfield import Array, Ints, Mask, StepField
from rsegen.geometry.mesh import Faces, LabelGrid, Lattice, Mesh, label_grid, welded
from rsegen.geometry.rectangles import merge, ragged
from rsegen.geometry.surface import risers, tops
from rsegen.params.watch import LARGE, tell

_FLAT = 1e-6
"""Share of the smallest area on the lattice below which a triangle counts as degenerate: real triangles are larger by
far, and rounding errors smaller."""

_NOWHERE, _ANYWHERE = -1, 3
"""Where a vertex may move, besides along the axes 0, 1 and 2."""

_PIECE = 2**14
"""Rows that are worked on at a time: their arrays fit into a processor's cache, which saves half the time and much
memory."""


class _Fan(NamedTuple):
    """The triangles around each vertex: the vertex, the next two vertices of a triangle, and the triangle's normal.

    Sorted by vertex, then by the second vertex.
    """

    vertex: Ints
    second: Ints
    third: Ints
    normal: Ints


class _Collapses(NamedTuple):
    """Edge collapses: the vertex that is removed, and the one that it is moved onto."""

    vertex: Ints
    target: Ints

    def rows(self, which: Ints | Mask) -> _Collapses:
        return _Collapses(self.vertex[which], self.target[which])


def decimated(pieces: Sequence[Faces], points: _Points, lattice: Lattice) -> tuple[Faces, Ints]:
    """Return the triangles of all pieces without removable vertices, and the points of the vertices that are left.

    pieces: corners (m, 3), indices of the points' vertices, all of which are used; in the result, indices of those
    left, which are in order.
    """
    owner = np.repeat(np.arange(len(points.places), dtype=np.int32), 1 + points.pinched)  # the point of each vertex
    ways = _ways(points, owner)
    removable = ways != _NOWHERE
    # A triangle without a removable corner never gets one, so it is left out of all rounds, and so are its vertices.
    takes_part = [_any(removable, piece.corners) for piece in pieces]
    parts = [piece.rows(np.flatnonzero(part)) for piece, part in zip(pieces, takes_part, strict=True)]
    corners, normals = (np.concatenate(column) for column in list(zip(*parts, strict=True))[:2])
    used, corners = welded(corners, len(owner))
    vertices = np.empty((len(used), 3))
    for axis, (line, at) in enumerate(zip(lattice.lines, points[1:4], strict=True)):
        vertices[:, axis] = line.take(at.take(owner.take(used)))
    place, kept = _collapsed(_Live(corners, normals, used, vertices, ways[used]), _FLAT * _least_area(lattice))
    left = np.ones(len(owner), dtype=bool)
    left[used] = place == np.arange(len(used))
    number = np.cumsum(left, dtype=np.int32) - 1
    number[used] = number[used[place]]
    gone = np.concatenate(takes_part)
    gone[gone] = ~kept  # all others stay
    pieces = [piece.rows(np.flatnonzero(~part)) for piece, part in zip(pieces, _split(gone, takes_part), strict=True)]
    triangles = (piece._replace(corners=number.take(piece.corners)) for piece in pieces)
    return Faces(*(np.concatenate(columns) for columns in zip(*triangles, strict=True))), owner[left]


class _Live(NamedTuple):
    """The triangles that have a removable vertex: corners (m, 3), normals (m,); and their vertices (n,).

    numbers, vertices, ways: the number of each vertex in the mesh; where it is, (n, 3), metres; and the axis along
    which it may move, or _ANYWHERE in its plane, or _NOWHERE.
    """

    corners: Ints
    normals: Ints
    numbers: Ints
    vertices: Array
    ways: Ints


def _collapsed(live: _Live, least: float) -> tuple[Ints, Mask]:
    """Return the vertex onto which each is moved in the end, itself if it stays, and which triangles are kept.

    least: twice the area below which a triangle counts as degenerate.
    """
    corners, normals, numbers, vertices, ways = live
    removable, place = ways != _NOWHERE, np.arange(len(vertices), dtype=np.int32)
    rows, kept = np.arange(len(corners)), np.ones(len(corners), dtype=bool)
    tried = removable
    while True:
        fan = _fan(corners, normals, tried)
        possible = _without_flips(_collapses(fan, vertices, ways), fan, vertices, least)
        collapses = _independent_collapses(possible, corners, numbers)
        if not len(collapses.vertex):
            break
        place[collapses.vertex] = collapses.target
        # A vertex that could not move can only do so once one of its triangles has changed.
        before, corners = corners, place.take(corners)
        tried = np.zeros(len(vertices), dtype=bool)
        tried[possible.vertex] = True
        tried[corners[np.not_equal(before, corners).any(axis=1)]] = True
        tried &= removable
        distinct = _are_distinct(*corners.T)
        kept[rows[~distinct]] = False
        stays = np.flatnonzero(distinct & _any(removable, corners))
        rows, corners, normals = rows.take(stays), corners.take(stays, axis=0), normals.take(stays)
    while (place != (further := place.take(place))).any():
        place = further  # a target may have been removed later
    return place, kept


def _pieces(array: NDArray[Any]) -> Sequence[NDArray[Any]]:
    """Return an array in pieces of at most _PIECE rows."""
    return np.array_split(array, 1 + len(array) // _PIECE)


def _split(mask: Mask, parts: Sequence[Mask]) -> list[Mask]:
    """Return a mask in pieces of the lengths of others."""
    return np.split(mask, np.cumsum([len(part) for part in parts])[:-1])


def _any(mask: Mask, corners: Ints) -> Mask:
    """Return which triangles (m, 3) have a corner in a mask of vertices."""
    a, b, c = corners.T
    return np.asarray(mask.take(a) | mask.take(b) | mask.take(c))


def _are_distinct(a: Ints, b: Ints, c: Ints) -> Mask:
    """Return which triples are of three distinct numbers."""
    return np.asarray((a != b) & (b != c) & (c != a))


def _fan(corners: Ints, normals: Ints, removable: Mask) -> _Fan:
    """Return the fans of triangles around removable vertices."""
    corner = np.flatnonzero(removable.take(corners))
    triangle, turn = np.divmod(corner.astype(np.int32), 3)
    flat = corners.ravel()
    vertex, second = flat.take(corner), flat.take(corner + 1 - 3 * (turn == 2))
    order = np.argsort(vertex.astype(np.int64) * len(removable) + second)
    third = flat.take(corner + 2 - 3 * (turn > 0))
    return _Fan(*(column.take(order) for column in (vertex, second, third, normals.take(triangle))))


def _collapses(fan: _Fan, vertices: Array, ways: Ints) -> _Collapses:
    """Return all collapses of vertices onto neighbours to which they may move."""
    # A triangle has one axis as its normal and may have the way as one side; the third then has to agree.
    way = ways.take(fan.vertex)
    third = (3 - way - fan.normal // 2) % 3
    along = vertices.take(3 * fan.third + third) == vertices.take(3 * fan.vertex + third)
    may = along | (way == _ANYWHERE)
    return _Collapses(fan.vertex[may], fan.third[may])


def _without_flips(collapses: _Collapses, fan: _Fan, vertices: Array, least: float) -> _Collapses:
    """Return one collapse per vertex that flips no triangle, if it has one."""
    # The collapses of all vertices, one per vertex at a time, in the order of the fan, until one is good.
    begins = np.flatnonzero(np.diff(fan.vertex, prepend=-1))
    counts = np.diff(begins, append=len(fan.vertex))
    own = np.searchsorted(fan.vertex[begins], collapses.vertex)
    found, waiting = [], np.flatnonzero(np.diff(collapses.vertex, prepend=-1))
    while len(waiting):
        trial, waiting = np.split(waiting, [_PIECE])
        # Every triangle of a vertex, with the target in its place; triangles that have the target as a corner vanish.
        move, place = ragged(counts.take(own.take(trial)))
        corner = begins.take(own.take(trial)).take(move) + place
        moved = collapses.target.take(trial).take(move), fan.second.take(corner), fan.third.take(corner)
        over = (_twice_areas(*moved, fan.normal.take(corner), vertices) < least) & _are_distinct(*moved)
        good = np.bincount(move[over], minlength=len(trial)) == 0
        found.append(trial[good])
        following = trial[~good] + 1
        following = following[following < len(own)]
        waiting = np.concatenate([waiting, following[own[following] == own[following - 1]]])
    return collapses.rows(np.sort(np.concatenate(found))) if found else collapses


def _independent_collapses(collapses: _Collapses, corners: Ints, numbers: Ints) -> _Collapses:
    """Return collapses of which no two change the same triangle: of those that do, the one with the smallest hash.

    The hash of a vertex's number in the mesh (Knuth's multiplicative one, 2^32 / golden ratio) mixes neighbouring
    vertices; with the number itself whole rows would wait for their first vertex, and there would be as many rounds as
    a row has vertices.
    """
    lot = np.full(len(numbers), 2**32 - 1, dtype=np.uint32)  # of a vertex that stays; no number below 4050964655 has it
    lot[collapses.vertex] = numbers[collapses.vertex].astype(np.uint32) * np.uint32(2654435761)
    a, b, c = (lot.take(corner) for corner in corners.T)
    first = np.minimum(np.minimum(a, b), c)
    loses = np.zeros(len(numbers), dtype=bool)
    for corner, own in zip(corners.T, (a, b, c), strict=True):
        loses[corner.compress(own > first)] = True
    return collapses.rows(~loses[collapses.vertex])


def _twice_areas(a: Ints, b: Ints, c: Ints, normals: Ints, vertices: Array) -> Array:
    """Return twice the signed area of triangles with corners a, b, c; negative if one has flipped."""
    # In the plane of two axes, u and v, which turn into the third as x and y turn into z.
    axis, back = np.divmod(normals, 2)
    u, v = (axis + 1) % 3, (axis + 2) % 3
    (u_a, v_a), (u_b, v_b), (u_c, v_c) = ([vertices.take(3 * corner + at) for at in (u, v)] for corner in (a, b, c))
    twice = (u_b - u_a) * (v_c - v_a) - (v_b - v_a) * (u_c - u_a)
    return np.asarray(np.where(back, -twice, twice))


class _Points(NamedTuple):
    """The points at which rectangles have corners, in order, and the four cells around each.

    places, x, y, z: (n,), the number of the lattice point, and its indices; labels, ranks: (2, 2, n), of the cells
    before and beyond it along x and along y; pinched: (n,), whether two diagonally opposite blocks touch at the point
    while the other two are lower; first: (n,), its vertex, or the first of the two vertices that it has if pinched.
    """

    places: Ints
    x: Ints
    y: Ints
    z: Ints
    labels: Ints
    ranks: Ints
    pinched: Mask
    first: Ints

    @classmethod
    def of(cls, places: Ints, grid: LabelGrid) -> _Points:
        """Return the points of these numbers; arrays have the smallest type, a quarter of the memory and the time."""
        x, y, z = grid.lattice.unravelled(places)
        small = np.min_scalar_type(int(grid.labels.max()))
        cells, columns = grid.labels.astype(small).ravel(), grid.labels.shape[1]
        before = x * np.int32(columns) + y  # the cell before a point, along x and y
        labels = np.stack([[cells[i * columns + j :].take(before) for j in (0, 1)] for i in (0, 1)])
        ranks = labels // small.type(grid.materials)
        z = z.astype(small)
        (a, b), (c, d) = ranks >= np.maximum(z, 1)
        pinched = (a == d) & (b == c) & (a != b)
        first = np.arange(len(places), dtype=np.int32) + np.cumsum(pinched, dtype=np.int32) - pinched
        return cls(places, x, y, z, labels, ranks, pinched, first)


def watertight(field: StepField) -> Mesh:
    """Return the watertight mesh of a field, in triangles; empty if every cell is at level 0."""
    grid = label_grid(field)
    rings = Faces.joined([tops(grid), bottoms(grid), risers(grid, axis=0), risers(grid, axis=1)])
    large = rings.corners.size > LARGE

    def told(share: float) -> None:
        """Tell the share of the time that a map of a thousand cells to each side has taken by then."""
        if large:
            tell("a closed mesh", share)

    told(0.3)
    places, corners = welded(rings.corners, prod(grid.lattice.shape))
    rings = Faces(corners, rings.normals.astype(np.int8), rings.materials.astype(np.int16))
    points = _Points.of(places, grid)
    told(0.4)
    triangles = _triangulated(rings, points, grid.lattice)
    told(0.7)
    faces, left = decimated(triangles, points, grid.lattice)
    told(1)
    return grid.lattice.mesh(faces, places[left])


def bottoms(grid: LabelGrid) -> Faces:
    """Return the faces downward at z = 0, split into rectangles; all have the material of the lowest block."""
    rectangles = merge((grid.cells != 0).astype(np.int8))
    ring = grid.lattice.corners_of(rectangles, (0, 1), np.zeros_like(rectangles.u0))[:, ::-1]
    material = (grid.cells[grid.cells != 0] % grid.materials).min(initial=grid.materials)
    return Faces(ring, np.full(len(ring), 5), np.full(len(ring), material))


def _ways(points: _Points, owner: Ints) -> Ints:
    """Return where each vertex may move, (v,); owner: (v,), its point.

    The labels around a point say so. A crease is a piece of the lattice's lines at which the surface turns or changes
    its material. A vertex at which none ends may move in its plane, and one at which just two end, both on one line,
    along that line.
    """
    labels, ranks, z = points.labels, points.ranks, points.z
    # Level creases are between two cells that differ, one of which has its top (at 0: its bottom, or ground) here.
    is_top = ranks == z
    along_x = (labels[:, 0] != labels[:, 1]) & (is_top[:, 0] | is_top[:, 1])
    along_y = (labels[0] != labels[1]) & (is_top[0] | is_top[1])
    along_z = _upright_creases((ranks >= z) & (z > 0), labels), _upright_creases(ranks > z, labels)
    ends = [a.astype(np.int8) + b for a, b in (along_x, along_y, along_z)]
    creases = sum(ends)
    way = np.full(len(z), _NOWHERE, dtype=np.int8)
    for axis, own in enumerate(ends):
        way[(own == 2) & (creases == 2)] = axis
    way[creases == 0] = _ANYWHERE
    ways = way[owner]
    # A pinched point has an upright crease on each of its sheets, which ends where the sheet's block does.
    pinched = np.flatnonzero(points.pinched)
    for sheet in (0, 1):
        goes_on = (ranks[:, sheet, pinched].max(axis=0, initial=0) > z[pinched]) & (z[pinched] > 0)
        ways[points.first[pinched] + sheet] = np.where(goes_on, 2, _NOWHERE)
    return ways


def _upright_creases(solid: Mask, labels: Ints) -> Mask:
    """Return whether the line between four cells is a crease where these are solid: all are (2, 2, n).

    It is none inside a solid, in the air, and on a flat wall of one material.
    """
    of_one = labels[:, 0] == labels[:, 1], labels[0] == labels[1]
    pairs = (solid[:, 0], solid[:, 1]), (solid[0], solid[1])
    flat = [((a == b) & (alike | ~a)).all(axis=0) for alike, (a, b) in zip(of_one, pairs, strict=True)]
    return np.asarray(~(solid.all(axis=(0, 1)) | flat[0] | flat[1]))


def _least_area(lattice: Lattice) -> float:
    """Return twice the area of the smallest triangle on a lattice, if its lines are evenly apart."""
    gaps = [np.diff(line).min(initial=np.inf) for line in lattice.lines]
    return float(min(gaps[:2]) * min(gaps))


_FAR = np.array([[1, 0, 0, 1], [1, 0, 0, 1], [0, 0, 0, 0], [1, 1, 1, 1], [1, 1, 0, 0], [0, 0, 1, 1]], dtype=bool)
"""Corners of a face at which its block lies on the side of larger y, for each of NORMALS."""

_AXES = np.array([[1, 2, 1, 2], [0, 2, 0, 2], [0, 1, 0, 1]], dtype=np.int32)
"""Axis of each side of a rectangle that is perpendicular to x, y and z."""

_OPENING = np.array([1, 0, 1, 0])
"""How many edges of each side have no triangle of their own."""


def _triangulated(rings: Faces, points: _Points, lattice: Lattice) -> list[Faces]:
    """Return triangles of vertices for rectangles whose corners are points, in pieces."""
    # Points in three orders. By number, those on one line along z are consecutive: (x, y, z). Sorted by z again, those
    # on a line along y are: (z, x, y); and those along x after one more sort by y: (y, z, x). Both sorts keep the order
    # of equals; of 16 bits they are radix sorts, which are linear.
    small = np.uint16 if max(lattice.shape) <= 2**16 else np.int64
    count = len(points.places)
    along_y = np.argsort(points.z.astype(small), kind="stable")
    along_x = along_y.take(np.argsort(points.y.astype(small).take(along_y), kind="stable"))
    own = points.first * 2 + points.pinched
    rank = np.empty((count, 3), dtype=np.int32)
    for axis, order in enumerate((along_x, along_y, np.arange(count))):
        rank[order, axis] = np.arange(axis * count, (axis + 1) * count, dtype=np.int32)
    vertex = np.concatenate([own[along_x], own[along_y], own])
    return [_fans(Faces(*piece), rank.ravel(), vertex) for piece in zip(*map(_pieces, rings), strict=True)]


def _fans(rings: Faces, rank: Ints, vertex: Ints) -> Faces:
    """Return the triangles of rectangles, with all vertices on their sides.

    rank: (3 n,), where each point is in turn in the orders of points along x, y and z, which follow one another;
    vertex: (3 n,), 2 * the first vertex of the point in each place of these orders, plus 1 if it has two.

    c3 ____.____ c2    The edges of each side and one point: on the left the first after c0, on the right the first
      |        |       after c2; below, without the first edge, c3; above, without the first edge, c1.
      |________|
    c0     .    c1
    """
    # A side is a slice, forward or backward, of the order along its axis. The sides of all rectangles are one list.
    axis, corners = _AXES[rings.normals // 2], 3 * rings.corners
    start, end = (rank.take(axis + ends).ravel() for ends in (corners, corners[:, [1, 2, 3, 0]]))
    count, sign = np.abs(end - start), np.sign(end - start)
    first = np.cumsum(count, dtype=np.int32) - count
    at = np.repeat(sign, count)
    at[first] = start - np.roll(end - sign, 1) * (first > 0)
    point = vertex.take(np.cumsum(at, dtype=np.int32))
    point = (point >> 1) + (point & np.repeat(_FAR[rings.normals], count))
    first = first.reshape(-1, 4)
    after = np.roll(point, -1)
    after[np.roll(first[:, 0], -1) - 1] = point[first[:, 0]]
    edge = np.ones(len(point), dtype=bool)
    edge[first[:, ::2]] = False
    apexes = point.take(np.stack([first[:, 3], first[:, 2] + 1, first[:, 1], first[:, 0] + 1], axis=1))
    edges = count.reshape(-1, 4) - _OPENING
    triangles = edges.sum(axis=1)
    corners = np.stack([point.compress(edge), after.compress(edge), np.repeat(apexes, edges.ravel())], axis=1)
    return Faces(corners, np.repeat(rings.normals, triangles), np.repeat(rings.materials, triangles))
