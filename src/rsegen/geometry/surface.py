"""The exposed surface of a step field: tops and risers, merged, welded, outward.

Nothing faces down and nothing lies at z = 0, where the ground is. A riser belongs to the higher of its two cells:

         ____
        |top |      level 2: top at rank 2, riser from rank 1 to 2
    ____|    |____
                    level 1 on both sides
"""

from __future__ import annotations

from collections.abc import Callable
from math import prod
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rsegen.geometry.mesh import Mesh
from rsegen.geometry.rectangles import Ints, Rectangles, merge_squares, merge_strips
from rsegen.stepfield import StepField

_Corners = NDArray[np.int64]


class _Faces(NamedTuple):
    """Rectangles: (m, 4, 3) corners by number of x line, y line and height; where they look, what they are of."""

    corners: _Corners
    normals: Ints
    materials: Ints


def surface(field: StepField) -> Mesh:
    """The mesh of a field; empty where every cell is at level 0."""
    tops, ranks = np.unique(np.append(field.heights, 0.0), return_inverse=True)
    rank = ranks[:-1].reshape(field.shape)
    material = np.where(field.frame, 0, field.levels).astype(np.int64)
    parts = [_tops(rank, material), *_risers(rank, material, axis=0), *_risers(rank, material, axis=1)]
    faces = _Faces(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))
    order = np.argsort(faces.materials, kind="stable")
    edges_x, edges_y = field.edges()
    lines = (edges_x, edges_y, tops)
    grid = tuple(map(len, lines))
    codes, numbers = _welded(np.ravel_multi_index(tuple(np.moveaxis(faces.corners[order], 2, 0)), grid), prod(grid))
    places = np.unravel_index(codes, grid)
    return Mesh(
        vertices=np.stack([line[at] for line, at in zip(lines, places, strict=True)], axis=1),
        faces=numbers.astype(np.int32),
        normals=faces.normals[order].astype(np.int8),
        materials=faces.materials[order].astype(np.int16),
    )


def _welded(codes: Ints, possible: int) -> tuple[Ints, Ints]:
    """Every code below `possible` that comes, once and sorted; and for each given code its number among them."""
    if possible > 16 * codes.size:
        found, numbers = np.unique(codes, return_inverse=True)
        return found, numbers.reshape(codes.shape)
    used = np.zeros(possible, dtype=bool)
    used[codes] = True
    return np.flatnonzero(used), (np.cumsum(used) - 1)[codes]


def _tops(rank: Ints, material: Ints) -> _Faces:
    """One plane for each height and material."""
    x, y = np.nonzero(rank)
    kinds = int(material.max()) + 1
    found = merge_squares(rank[x, y] * kinds + material[x, y], x, y)
    height, of = np.divmod(found.plane, kinds)
    corners = _ring(found, lambda u, v: (u, v, height))
    return _Faces(corners, np.full(len(height), 4), of)


def _risers(rank: Ints, material: Ints, axis: int) -> list[_Faces]:
    """The two sides, looking along +axis and -axis."""
    turned = (rank, material) if axis == 0 else (rank.T, material.T)
    return [_side(*turned, axis, forward=forward) for forward in (True, False)]


def _side(rank: Ints, material: Ints, axis: int, *, forward: bool) -> _Faces:
    """Risers between neighbours along the first array axis, those that look forward or those that look back.

    A plane for each line between cells and each material; in it u counts cells across and v heights. In one plane all
    risers end at one height, so where neighbours begin at one height too they are one rectangle.
    """
    around = np.pad(rank, ((1, 1), (0, 0)))
    higher, lower = (around[:-1], around[1:]) if forward else (around[1:], around[:-1])
    line, u = np.nonzero(higher > lower)
    kinds = int(material.max()) + 1
    plane = line * kinds + material[line - 1 if forward else line, u]
    found = merge_strips(plane, u, lower[line, u], higher[line, u])
    line, of = np.divmod(found.plane, kinds)
    ring = _ring(found, (lambda u, v: (line, u, v)) if axis == 0 else (lambda u, v: (u, line, v)))
    outward = forward == (axis == 0)
    normal = 2 * axis + (0 if forward else 1)
    return _Faces(ring if outward else ring[:, ::-1], np.full(len(of), normal), of)


def _ring(found: Rectangles, place: Callable[[Ints, Ints], tuple[Ints, ...]]) -> _Corners:
    """The four corners in turn, (m, 4, 3), where `place` gives x line, y line and height from u and v."""
    turns = ((found.u0, found.v0), (found.u1, found.v0), (found.u1, found.v1), (found.u0, found.v1))
    corners = [np.stack(np.broadcast_arrays(*place(u, v)), axis=1) for u, v in turns]
    return np.stack(corners, axis=1) if len(found.plane) else np.empty((0, 4, 3), dtype=np.int64)
