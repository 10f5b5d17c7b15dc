r"""The closed mesh of a step field: no gaps, no T-junctions, the volume of its blocks, few triangles.

Every rectangle of the merged surface, and of the bottoms at z = 0, is triangulated with all corners of others that lie
on its sides, so that triangles meet edge to edge; then vertices that are not needed are decimated by edge collapses
that do not change the surface:

     o---x---o          o-------o       x, inside a plane or on a straight edge between two planes, moves onto a
     |       |   -->    |       |       neighbour (in the second case along that edge), if no triangle flips; the
     o-------o          o-------o       two triangles between them disappear

Which vertices those are is known before there is a triangle, from the labels of the four cells around each (`_ways`):
on random maps one in ten, so only one triangle in five takes part in the rounds of collapses. In triangles such a
vertex stands as the complement of its number, a negative one.

    n3-------n2          n3-------n2     The fan of x, and x moved onto n1: the two triangles with n1 disappear, the
    | \     / |          | \       |     others have n1 in the place of x. None of these may flip or lose its area; if
    |    x    |   -->    |    \    |     one would, the next neighbour is tried.
    | /     \ |          |       \ |
    n0-------n1          n0-------n1

Vertices move in rounds, as in arrays they cannot move one after the other: in a round all that can, but of those that
share a triangle only one, as no fan may change while it is judged. A vertex that could not move is tried again when one
of its triangles has changed. The collapses take away one triangle in thirteen on random maps, one in fifteen in the
examples; they stay because a recipe is to give the same bytes of a mesh as before.

If two blocks touch only along a vertical edge, each has vertices of its own there, as an edge with four faces would not
be manifold:

      ___            the corner in the middle, seen from above, is `pinched`: it has two vertices, on two sheets;
     |_a_|___        the block on the side of larger y takes the second
         |_b_|

Cost: linear in the corners, and the sorting of fans; on random maps about five times the merged surface, of which
triangulation and decimation take a third each. Whole maps only: a tile of a closed mesh would have walls inside the map
(decision 7).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence, Sized
from itertools import pairwise
from math import prod
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rsegen.field.stepfield import Array, Ints, Mask, StepField
from rsegen.geometry.exposed_faces import risers, tops
from rsegen.geometry.mesh import Faces, LabelGrid, Mesh, VertexGrid, label_grid, welded
from rsegen.geometry.rectangles import merge, ragged
from rsegen.params.watch import LARGE, report_share

_FLAT = 1e-6
"""Share of the smallest area on the lattice below which a triangle counts as degenerate: real triangles are larger by
far, and rounding errors smaller."""

_NOWHERE, _ANYWHERE = -1, 3
"""Codes of a vertex that may not move, and of one that may move along all axes; 0, 1 and 2 are single axes."""

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


def _decimated(pieces: Sequence[Faces], points: _Points, ways: Ints, lattice: VertexGrid) -> tuple[Faces, Ints]:
    """Return the triangles of all pieces without removable vertices, and which vertices are left.

    pieces: corners (m, 3), codes of vertices, all of which are used; in the result, indices of those left, which are in
    order. ways: (v,), where each vertex may move.
    """
    # A triangle without a removable corner never gets one, so it is left out of all rounds, and so are its vertices.
    takes_part = [(a | b | c) < 0 for a, b, c in (piece.corners.T for piece in pieces)]
    rows = [np.flatnonzero(part) for part in takes_part]
    parts = [piece.rows(part) for piece, part in zip(pieces, rows, strict=True)]
    used, place, kept = _collapsed(parts, points, ways, lattice)
    left = np.ones(len(ways), dtype=bool)
    left[used] = place == np.arange(len(used))
    number = np.cumsum(left, dtype=np.int32) - 1
    number[used] = number[used[place]]
    for part, row, stays in zip(takes_part, rows, _split(kept, rows), strict=True):
        part[row] = ~stays  # all others stay
    triangles = (piece.rows(np.flatnonzero(~gone)) for piece, gone in zip(pieces, takes_part, strict=True))
    return _by_material(triangles, number), left


def _by_material(pieces: Iterable[Faces], number: Ints) -> Faces:
    """Return the faces of pieces, each of which is sorted by material, sorted by material, else in their order.

    number: (v,), the new number of each vertex.
    """
    # Runs of one material are sorted, not faces: a stable sort of a few runs in place of millions of rows.
    runs: list[Faces] = []
    for piece in pieces:
        cuts = np.flatnonzero(np.diff(piece.materials)) + 1
        bounds = pairwise([0, *cuts.tolist(), len(piece.materials)])
        runs += [Faces(*(column[begin:end] for column in piece)) for begin, end in bounds]
    runs.sort(key=lambda run: run.materials[:1].tolist())
    normals, materials = (np.concatenate(column) for column in list(zip(*runs, strict=True))[1:])
    corners = np.empty((len(normals), 3), dtype=np.int32)
    number = np.concatenate([number, number[::-1]])  # a complement, -1 - v, is an index from the end
    for run, part in zip(runs, _split(corners, [run.normals for run in runs]), strict=True):
        number.take(run.corners, out=part, mode="wrap")
    return Faces(corners, normals, materials)


def _collapsed(parts: Sequence[Faces], points: _Points, ways: Ints, lattice: VertexGrid) -> tuple[Ints, Ints, Mask]:
    """Return the numbers of the vertices of triangles that have a removable one; the index among them of the vertex
    onto which each is moved in the end, its own if it stays; and which triangles are kept.
    """
    # These triangles alone, with their vertices numbered anew; lattice lines give the coordinates.
    corners = np.concatenate([part.corners for part in parts])
    normals = np.concatenate([part.normals for part in parts])
    numbers, corners = welded(np.maximum(corners, ~corners), len(ways))
    ways, at = ways.take(numbers), points.owner.take(numbers)
    vertices = np.stack([line.take(place.take(at)) for line, place in zip(lattice.lines, points[1:4], strict=True)], 1)
    gaps = [np.diff(line).min(initial=np.inf) for line in lattice.lines]
    least = _FLAT * float(min(gaps[:2]) * min(gaps))  # of twice the area of the smallest triangle on the lattice
    removable, place = ways != _NOWHERE, np.arange(len(vertices), dtype=np.int32)
    # `corners` and `normals` shrink from round to round to the triangles that can still change; `rows` are their places
    # in `kept`.
    rows, kept = np.arange(len(corners)), np.ones(len(corners), dtype=bool)
    tried = removable
    while True:  # a round
        movable, targets = _possible_collapses(_fan(corners, normals, tried), vertices, ways, least)
        chosen = _are_independent(movable, corners, numbers)
        if not chosen.any():
            break
        place[movable[chosen]] = targets[chosen]
        # A target never moves in the same round: it has a triangle in common with the vertex that moves onto it.
        changed = np.flatnonzero(_any(_mask(movable[chosen], len(place)), corners))
        moved = place.take(corners.take(changed, axis=0))
        # A vertex that could not move can only do so once one of its triangles has changed.
        tried = _mask(movable, len(place))
        tried[moved] = True
        tried &= removable
        # A triangle with two equal corners has collapsed; one without a removable corner is done.
        a, b, c = moved.T
        distinct = (a != b) & (b != c) & (c != a)
        kept[rows[changed[~distinct]]] = False
        corners[changed] = moved
        stays = np.ones(len(corners), dtype=bool)
        stays[changed] = distinct & _any(removable, moved)
        stay = np.flatnonzero(stays)
        rows, corners, normals = rows.take(stay), corners.take(stay, axis=0), normals.take(stay)
    while (place != (further := place.take(place))).any():
        place = further  # a target may have been removed later
    return numbers, place, kept


def _split(column: NDArray[Any], parts: Sequence[Sized]) -> list[NDArray[Any]]:
    """Return an array in pieces of the lengths of others."""
    return np.split(column, np.cumsum([len(part) for part in parts])[:-1])


def _mask(which: Ints, length: int) -> Mask:
    """Return a mask that is true at these indices."""
    mask = np.zeros(length, dtype=bool)
    mask[which] = True
    return mask


def _any(mask: Mask, corners: Ints) -> Mask:
    """Return which triangles (m, 3) have a corner in a mask of vertices."""
    a, b, c = corners.T
    return np.asarray(mask.take(a) | mask.take(b) | mask.take(c))


def _fan(corners: Ints, normals: Ints, removable: Mask) -> _Fan:
    """Return the fans of triangles around removable vertices."""
    # A triangle is in the fan of each of its corners that is removable: as (a b c), (b c a) and (c a b).
    columns, parts = corners.T, []
    for turn, vertex in enumerate(columns):
        rows = np.flatnonzero(removable.take(vertex))
        parts.append([column.take(rows) for column in (*columns[turn:], *columns[:turn], normals)])
    vertex, second, third, normal = (np.concatenate(column) for column in zip(*parts, strict=True))
    order = np.argsort(vertex.astype(np.int64) * len(removable) + second)
    return _Fan(*(column.take(order) for column in (vertex, second, third, normal)))


def _possible_collapses(fan: _Fan, vertices: Array, ways: Ints, least: float) -> tuple[Ints, Ints]:
    """Return the vertices with an edge collapse that flips no triangle, and the vertex onto which each moves."""
    # A triangle has one axis as its normal and may have the way as one side; the other axis then has to agree.
    way = ways.take(fan.vertex)
    other = (3 - way - fan.normal // 2) % 3
    along = vertices.take(3 * fan.third + other) == vertices.take(3 * fan.vertex + other)
    rows = np.flatnonzero(along | (way == _ANYWHERE))
    # The collapses of all vertices, one per vertex at a time, in the order of the fan, until one is good.
    # A row of the fan stands for the collapse onto its third vertex, so all neighbours of a vertex are candidates.
    is_first = np.diff(fan.vertex, prepend=-1) != 0
    begins = np.flatnonzero(is_first)
    counts = np.diff(begins, append=len(fan.vertex))
    own = (np.cumsum(is_first) - 1).take(rows)
    good, waiting = [rows[:0]], np.flatnonzero(np.diff(own, prepend=-1))
    while len(waiting):
        trial, waiting = waiting[:_PIECE], waiting[_PIECE:]
        # Every triangle of a vertex, with the target in its place; triangles that have the target as a corner vanish.
        fans = own.take(trial)
        move, place = ragged(counts.take(fans))
        corner = begins.take(fans).take(move) + place
        target = fan.third.take(rows.take(trial)).take(move)
        second, third = fan.second.take(corner), fan.third.take(corner)
        stay = np.flatnonzero((target != second) & (target != third))
        a, b, c = (column.take(stay) for column in (target, second, third))
        over = move.take(stay)[_twice_areas(a, b, c, fan.normal.take(corner.take(stay)), vertices) < least]
        # Vertices with no triangle that flips are done; the others wait with their next candidate, if they have one.
        is_good = np.bincount(over, minlength=len(trial)) == 0
        good.append(trial[is_good])
        following = trial[~is_good] + 1
        following = following[following < len(own)]
        waiting = np.concatenate([waiting, following[own[following] == own[following - 1]]])
    chosen = rows.take(np.sort(np.concatenate(good)))
    return fan.vertex.take(chosen), fan.third.take(chosen)


def _are_independent(vertex: Ints, corners: Ints, numbers: Ints) -> Mask:
    """Return a mask of vertices of which no two have a triangle in common: of those that do, the smallest hash stays.

    The hash of a vertex's number in the mesh (Knuth's multiplicative one, 2^32 / golden ratio) mixes neighbouring
    vertices; with the number itself whole rows would wait for their first vertex, and there would be as many rounds as
    a row has vertices.
    """
    lot = np.full(len(numbers), 2**32 - 1, dtype=np.uint32)  # of a vertex that stays; no number below 4050964655 has it
    lot[vertex] = numbers[vertex].astype(np.uint32) * np.uint32(2654435761)
    a, b, c = (lot.take(corner) for corner in corners.T)
    first = np.minimum(np.minimum(a, b), c)
    loses = np.zeros(len(numbers), dtype=bool)
    for corner, own in zip(corners.T, (a, b, c), strict=True):
        loses[corner.compress(own > first)] = True
    return ~loses[vertex]


_PLANES = np.array([[1, 1, 2, 2, 0, 0], [2, 2, 0, 0, 1, 1]], dtype=np.int32)
"""Axes u and v that turn into that of each of NORMALS as x and y turn into z."""


def _twice_areas(a: Ints, b: Ints, c: Ints, normals: Ints, vertices: Array) -> Array:
    """Return twice the signed area of triangles with corners a, b, c; negative if one has flipped."""
    u, v = (plane.take(normals) for plane in _PLANES)
    (u_a, v_a), (u_b, v_b), (u_c, v_c) = ([vertices.take(3 * corner + at) for at in (u, v)] for corner in (a, b, c))
    twice = (u_b - u_a) * (v_c - v_a) - (v_b - v_a) * (u_c - u_a)
    return np.asarray(np.where(normals & 1, -twice, twice))


class _Points(NamedTuple):
    """The points at which rectangles have corners, in order, and the four cells around each.

    places, x, y, z: (n,), the number of the lattice point, and its indices; labels, ranks: (2, 2, n), of the cells
    before and beyond it along x and along y; pinched: (n,), whether two diagonally opposite blocks touch at the point
    while the other two are lower; first: (n,), its vertex, or the first of the two vertices that it has if pinched;
    owner: (v,), the point of each vertex.
    """

    places: Ints
    x: Ints
    y: Ints
    z: Ints
    labels: Ints
    ranks: Ints
    pinched: Mask
    first: Ints
    owner: Ints

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
        number = np.arange(len(places), dtype=np.int32)
        first = number + np.cumsum(pinched, dtype=np.int32) - pinched
        return cls(places, x, y, z, labels, ranks, pinched, first, np.repeat(number, 1 + pinched))


def watertight(field: StepField) -> Mesh:
    """Return the watertight mesh of a field, in triangles; empty if every cell is at level 0."""
    grid = label_grid(field)
    flat = [tops(grid), bottoms(grid)]
    sides = [Faces.joined(parts) for parts in (flat, [risers(grid, axis=0)], [risers(grid, axis=1)])]
    corners = np.concatenate([rings.corners for rings in sides])
    large = corners.size > LARGE

    def report_work(share: float) -> None:
        """Report the share of the time that a map of a thousand cells to each side has taken by then."""
        if large:
            report_share("a closed mesh", share)

    report_work(0.3)
    places, corners = welded(corners, prod(grid.lattice.shape))
    sides = [
        Faces(corner, rings.normals.astype(np.int8), rings.materials.astype(np.int16))
        for corner, rings in zip(_split(corners, [rings.corners for rings in sides]), sides, strict=True)
    ]
    points = _Points.of(places, grid)
    ways = _ways(points)
    report_work(0.4)
    # A removable vertex has a negative code, so that a triangle's corners say whether it has one.
    number = np.arange(len(ways), dtype=np.int32)
    orders = _Orders.of(points, np.where(ways != _NOWHERE, ~number, number), grid.lattice)
    triangles = [
        _fans(Faces(*(column[begin : begin + _PIECE] for column in rings)), axes, orders)
        for axes, rings in zip(((0, 1), (1, 2), (0, 2)), sides, strict=True)
        for begin in range(0, max(len(rings.normals), 1), _PIECE)
    ]
    report_work(0.7)
    faces, left = _decimated(triangles, points, ways, grid.lattice)
    report_work(1)
    owner = points.owner.compress(left)
    return grid.lattice.mesh(faces, [at.take(owner) for at in points[1:4]])


def bottoms(grid: LabelGrid) -> Faces:
    """Return the faces downward at z = 0, split into rectangles; all have the material of the lowest block."""
    rectangles = merge((grid.cells != 0).astype(np.int8))
    ring = grid.lattice.corners_of(rectangles, (0, 1), np.zeros_like(rectangles.u0))[:, ::-1]
    material = (grid.cells[grid.cells != 0] % grid.materials).min(initial=grid.materials)
    return Faces(ring, np.full(len(ring), 5), np.full(len(ring), material))


def _ways(points: _Points) -> Ints:
    """Return where each vertex may move, (v,).

    The labels around a point say so. A crease is a piece of the lattice's lines at which the surface turns or changes
    its material. A vertex without a crease may move in its plane; one at which two creases of one line end, along it.
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
    ways = way.take(points.owner)
    # A pinched point has an upright crease on each of its sheets, which ends where the sheet's block does.
    pinched = np.flatnonzero(points.pinched)
    for sheet in (0, 1):
        top = np.maximum(*(rank.take(pinched) for rank in ranks[:, sheet]))
        goes_on = (top > z[pinched]) & (z[pinched] > 0)
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


_FAR = np.array([[1, 0, 0, 1], [1, 0, 0, 1], [0, 0, 0, 0], [1, 1, 1, 1], [1, 1, 0, 0], [0, 0, 1, 1]], dtype=np.int32)
"""1 for the sides of a face at which its block lies on the side of larger y, for each of NORMALS."""

_APEXES = np.array([0, 1, 0, 1], dtype=np.int32)
"""Steps from the first point of the sides 3, 2, 1, 0 to the point where the edges of the sides 0, 1, 2, 3 end."""


class _Orders(NamedTuple):
    """The points in three orders, in each of which those on a line along an axis are consecutive.

    code: (6 n,), the codes of vertices: for each axis, the first vertex of each point in the order along it, and then
    the second if it has two, else again the first. along_x, along_y: (n,), where in `code` each point is; along z its
    own number.
    """

    code: Ints
    along_x: Ints
    along_y: Ints

    @classmethod
    def of(cls, points: _Points, code: Ints, lattice: VertexGrid) -> _Orders:
        # By number, points on one line along z are consecutive: (x, y, z). Sorted by z again, those on a line along y
        # are: (z, x, y); and those along x after one more sort by y: (y, z, x). Both sorts keep the order of equals; of
        # 16 bits they are radix sorts, which are linear.
        small = np.uint16 if max(lattice.shape) <= 2**16 else np.int64
        count = len(points.places)
        by_y = np.argsort(points.z.astype(small), kind="stable")
        by_x = by_y.take(np.argsort(points.y.astype(small).take(by_y), kind="stable"))
        along_x, along_y = np.empty((2, count), dtype=np.int32)
        along_x[by_x] = np.arange(2 * count, 3 * count, dtype=np.int32)
        along_y[by_y] = np.arange(4 * count, 5 * count, dtype=np.int32)
        first = code.take(points.first)
        codes = np.concatenate([first, first, *2 * [first.take(by_x)], *2 * [first.take(by_y)]])
        pinched = np.flatnonzero(points.pinched).astype(np.int32)
        second = code.take(points.first.take(pinched) + 1)
        for rank in (pinched, along_x.take(pinched), along_y.take(pinched)):
            codes[rank + count] = second
        return cls(codes, along_x, along_y)

    def ranks(self, corners: Ints, axis: int) -> Ints:
        """Return where in `code` points are, in the order along an axis."""
        return corners if axis == 2 else self[1 + axis].take(corners)


def _fans(rings: Faces, axes: tuple[int, int], orders: _Orders) -> Faces:
    """Return the triangles of rectangles, with all vertices on their sides.

    axes: along which their sides are, in turn, from c0 on.

    c3 ____.____ c2    The edges of each side and one point: on the left the first after c0, on the right the first
      |        |       after c2; below, without the first edge, c3; above, without the first edge, c1.
      |________|
    c0     .    c1
    """
    # A side is a slice, forward or backward, of the order along its axis, from `start` up to but not including `end`.
    # The sides of all rectangles are one list, in which they are found by steps: to the next point, or to a `start`.
    u, v = (orders.ranks(rings.corners, axis) for axis in axes)
    start, end = np.empty((2, *u.shape), dtype=np.int32)
    start[:, ::2], start[:, 1::2] = u[:, ::2], v[:, 1::2]
    end[:, ::2], end[:, 1], end[:, 3] = u[:, 1::2], v[:, 2], v[:, 0]
    end -= start
    sign = np.sign(end)
    count = np.abs(end)
    start += (_FAR * (len(orders.code) // 6)).take(rings.normals, axis=0)
    end += start
    end -= sign
    start.ravel()[1:] -= end.ravel()[:-1]  # from here on: the step from the last point of the side before
    first = np.cumsum(count, dtype=np.int32).reshape(-1, 4)
    total = int(first[-1, -1]) if len(first) else 0
    first -= count
    # Most sides are one edge; the other points of longer ones are set apart, as to repeat a value per side is slower.
    inner = np.flatnonzero(~_mask(first, total))
    long = np.flatnonzero(count > 1)
    side = np.repeat(long, count.take(long) - 1)
    step = np.empty(total, dtype=np.intp)
    step[first], step[inner] = start, sign.take(side)
    point = orders.code.take(np.cumsum(step, out=step))
    apexes = point.take(first[:, [3, 2, 1, 0]] + _APEXES)
    apex = np.empty(total, dtype=np.int32)
    apex[first], apex[inner] = apexes, apexes.take(side)
    edges = np.flatnonzero(~_mask(first[:, ::2], total))
    triangles = np.diff(first[:, 0], append=np.int32(total)) - 2
    corners = np.empty((len(edges), 3), dtype=np.int32)
    corners[:, 0] = point.take(edges)
    corners[:, 2] = apex.take(edges)
    corners[:, 1] = point.take(edges + 1, mode="clip")
    corners[np.cumsum(triangles) - 1, 1] = point.take(first[:, 0])  # the last edge of a rectangle ends where it begins
    return Faces(corners, np.repeat(rings.normals, triangles), np.repeat(rings.materials, triangles))
