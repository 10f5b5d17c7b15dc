"""Decimation of a closed triangle mesh by edge collapses that do not change its surface.

A vertex is removable inside a plane or on a straight edge between two planes. It is collapsed onto a neighbour, in the
second case along that edge, if no triangle flips; the two triangles between them disappear.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rsegen.field.stepfield import Array, Ints, Mask
from rsegen.geometry.chords import ragged
from rsegen.geometry.faces import Faces
from rsegen.geometry.mesh import NORMALS

_FLAT = 1e-6
"""Triangles of less than this share of the smallest initial area count as degenerate."""


class _Fan(NamedTuple):
    """The triangles around each vertex: the vertex, the next two vertices of a triangle, and the triangle's number.

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
    """The triangles without removable vertices; faces.corners (m, 3) are indices of vertices (n, 3)."""
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
    """The fans of triangles around the wanted vertices."""
    turned = [np.roll(corners, -turn, axis=1)[wanted[corners[:, turn]]] for turn in range(3)]
    triangle = np.concatenate([np.flatnonzero(wanted[corners[:, turn]]) for turn in range(3)])
    vertex, second, third = np.concatenate(turned).T
    order = np.argsort(vertex * len(wanted) + second)
    return _Fan(*(column[order] for column in (vertex, second, third, triangle)))


def _collapses(fan: _Fan, faces: Faces, vertices: Array) -> _Collapses:
    """All collapses of removable vertices onto neighbours that keep planes and edges in place."""
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
    """One collapse per vertex that flips no triangle, if it has one."""
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
    """Collapses of which no two change the same triangle, chosen by a hash of the vertex number."""
    lot = np.full(len(fan.vertex) and int(fan.vertex.max()) + 1, -1)
    lot[collapses.vertex] = collapses.vertex * 2654435761 % 2**32
    mine = lot[fan.vertex]
    first = np.full(triangles, 2**32)
    np.minimum.at(first, fan.triangle[mine >= 0], mine[mine >= 0])
    loses = np.bincount(fan.vertex[(mine >= 0) & (first[fan.triangle] != mine)], minlength=len(lot)) > 0
    return collapses.rows(~loses[collapses.vertex])


def _twice_areas(faces: Faces, corners: Array) -> Array:
    """Twice the signed area of triangles with corners (m, 3, 3); negative if one has flipped."""
    a, b, c = np.moveaxis(corners, 1, 0)
    return np.asarray((np.cross(b - a, c - a) * NORMALS[faces.normals]).sum(axis=1))
