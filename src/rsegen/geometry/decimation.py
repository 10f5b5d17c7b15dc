"""Taking needless corners out of a closed mesh of triangles: its planes stay as they are, with fewer triangles.

A corner is needless in the middle of a plane, or of a straight edge between two planes. It is moved onto a neighbour,
in the second case along that edge, where no triangle around it turns over; the two triangles between them vanish.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rsegen.field.stepfield import Array, Ints, Mask
from rsegen.geometry.chords import ragged
from rsegen.geometry.faces import Faces
from rsegen.geometry.mesh import NORMALS

_FLAT = 1e-6
"""A triangle of less than this share of the smallest at first, twice its area, is a line."""


class _Fan(NamedTuple):
    """Corners of triangles around their vertices: a vertex, the next two of its triangle, and which triangle it is.

    Sorted by vertex, then by the second.
    """

    vertex: Ints
    second: Ints
    third: Ints
    triangle: Ints


class _Collapses(NamedTuple):
    """What could be moved where."""

    vertex: Ints
    target: Ints

    def rows(self, which: Ints | Mask) -> _Collapses:
        return _Collapses(self.vertex[which], self.target[which])


def decimated(faces: Faces, vertices: Array) -> Faces:
    """The triangles without their needless corners; faces.corners (m, 3) are numbers of vertices (n, 3)."""
    faces = faces._replace(corners=faces.corners.astype(np.int64))
    least = _FLAT * _twice_areas(faces, vertices[faces.corners]).min(initial=np.inf)
    removable = np.ones(len(vertices), dtype=bool)
    while True:
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
    """The corners of the wanted vertices."""
    turned = [np.roll(corners, -turn, axis=1)[wanted[corners[:, turn]]] for turn in range(3)]
    triangle = np.concatenate([np.flatnonzero(wanted[corners[:, turn]]) for turn in range(3)])
    vertex, second, third = np.concatenate(turned).T
    order = np.argsort(vertex * len(wanted) + second)
    return _Fan(*(column[order] for column in (vertex, second, third, triangle)))


def _collapses(fan: _Fan, faces: Faces, vertices: Array) -> _Collapses:
    """Every needless vertex onto each of its neighbours that it may move to."""
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
    """For each vertex one of its moves that turns no triangle over, where there is one."""
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
    """Moves of which no two change one triangle; which of those that do is as good as drawn by lot."""
    lot = np.full(len(fan.vertex) and int(fan.vertex.max()) + 1, -1)
    lot[collapses.vertex] = collapses.vertex * 2654435761 % 2**32
    mine = lot[fan.vertex]
    first = np.full(triangles, 2**32)
    np.minimum.at(first, fan.triangle[mine >= 0], mine[mine >= 0])
    loses = np.bincount(fan.vertex[(mine >= 0) & (first[fan.triangle] != mine)], minlength=len(lot)) > 0
    return collapses.rows(~loses[collapses.vertex])


def _twice_areas(faces: Faces, corners: Array) -> Array:
    """Twice the area of triangles whose corners (m, 3, 3) are given; negative where one has turned over."""
    a, b, c = np.moveaxis(corners, 1, 0)
    return np.asarray((np.cross(b - a, c - a) * NORMALS[faces.normals]).sum(axis=1))
