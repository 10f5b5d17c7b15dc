"""Meshes whose faces are perpendicular to the axes, and the lattice on which they are made.

All vertices lie where lines along x, y and z cross. Until the end a corner is one integer, the number of its lattice
point, so equal corners are equal integers: welding needs no tolerance, and metres appear only in `Mesh.lines`.

All geometry of a field, or of a window of it, is made from a `LabelGrid`: integer labels of height and material.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import prod
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rsegen.field.stepfield import Array, CellWindow, Ints, Mask, StepField, make_read_only, read_only_copies
from rsegen.geometry.rectangles import Rectangles
from rsegen.params.sorts import NANOMETRE_DIGITS

NORMALS = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]])
"""The normals that a face can have: +x, -x, +y, -y, +z, -z."""


@read_only_copies
@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Mesh:
    """Faces as indices of vertices, sorted by material.

    Attributes
    ----------
    lines : tuple of three ndarrays
        The distinct x, y and z coordinates of vertices, metres.
    places : ndarray of int32, shape (n, 3)
        The indices of each vertex in `lines`.
    faces : ndarray of int32, shape (m, 4) or (m, 3)
        The vertices of each face, counterclockwise seen from outside.
    normals : ndarray of int8, shape (m,)
        Row of NORMALS of each face.
    materials : ndarray of int16, shape (m,)
        0 for a frame, else the level of the block.
    """

    lines: tuple[Array, Array, Array]
    places: NDArray[np.int32]
    faces: NDArray[np.int32]
    normals: NDArray[np.int8]
    materials: NDArray[np.int16]

    def __post_init__(self) -> None:
        make_read_only(*self.lines, self.places, self.faces, self.normals, self.materials)

    @property
    def vertices(self) -> Array:
        """Coordinates of the vertices, (n, 3), metres."""
        return np.stack([line[at] for line, at in zip(self.lines, self.places.T, strict=True)], axis=1)

    @property
    def triangles(self) -> NDArray[np.int32]:
        """Faces as triangles: (2 m, 3), or (m, 3) if the faces are triangles."""
        return self.faces if self.faces.shape[1] == 3 else self.faces[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)

    def part(self, which: Mask) -> Mesh:
        """Return the mesh of the faces in a mask (m,), with the vertices that they use."""
        used, corners = np.unique(self.faces[which], return_inverse=True)
        return replace(
            self,
            places=self.places[used],
            faces=corners.reshape(-1, self.faces.shape[1]).astype(np.int32),
            normals=self.normals[which],
            materials=self.materials[which],
        )


class Faces(NamedTuple):
    """Faces: corners (m, 3 or 4), numbers of lattice points in order; normals (m,), rows of NORMALS; materials (m,)."""

    corners: Ints
    normals: Ints
    materials: Ints

    @classmethod
    def joined(cls, parts: Iterable[Faces]) -> Faces:
        """Return all faces of the parts, sorted by material."""
        faces = cls(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))
        return faces.rows(np.argsort(faces.materials.astype(np.int16), kind="stable"))

    def rows(self, which: Ints) -> Faces:
        """Return the faces of these indices."""
        return Faces(self.corners.take(which, axis=0), self.normals.take(which), self.materials.take(which))


@dataclass(frozen=True, kw_only=True, slots=True)
class VertexGrid:
    """The intersections of lines along x, y and z, numbered row by row; coordinates in metres."""

    lines: tuple[Array, Array, Array]

    @property
    def shape(self) -> tuple[int, int, int]:
        """Number of lines along each axis."""
        n_x, n_y, n_z = map(len, self.lines)
        return n_x, n_y, n_z

    @property
    def steps(self) -> tuple[int, int, int]:
        """Difference between the numbers of neighbouring points along each axis."""
        _, n_y, n_z = self.shape
        return n_y * n_z, n_z, 1

    @property
    def number(self) -> type[np.int32 | np.int64]:
        """Type of a point's number: half the memory, on all but the largest maps."""
        return np.int32 if prod(self.shape) < 2**31 else np.int64

    def corners_of(self, rectangles: Rectangles, axes: tuple[int, int], at: Ints) -> Ints:
        """Return the corners (m, 4) of rectangles along the axes u and v, each at an index of the third axis.

        The corners turn from u to v.
        """
        step_u, step_v, step_at = (self.steps[axis] for axis in (*axes, 3 - sum(axes)))
        corners = np.empty((len(rectangles.label), 4), dtype=self.number)
        low, high = rectangles.u0 * step_u + at * step_at, rectangles.u1 * step_u + at * step_at
        near, far = rectangles.v0 * step_v, rectangles.v1 * step_v
        for corner, (u, v) in enumerate(((low, near), (high, near), (high, far), (low, far))):
            corners[:, corner] = u + v
        return corners

    def weld(self, faces: Faces) -> Mesh:
        """Return the mesh of faces, with one vertex per lattice point that is used."""
        places, numbers = welded(faces.corners, prod(self.shape))
        return self.mesh(faces._replace(corners=numbers), self.unravelled(places))

    def mesh(self, faces: Faces, places: Sequence[Ints]) -> Mesh:
        """Return the mesh of faces whose corners are vertex indices, with the indices x, y and z of each vertex."""
        return Mesh(
            lines=self.lines,
            places=np.stack([at.astype(np.int32, copy=False) for at in places], axis=-1),
            faces=faces.corners.astype(np.int32, copy=False),
            normals=faces.normals.astype(np.int8, copy=False),
            materials=faces.materials.astype(np.int16, copy=False),
        )

    def unravelled(self, places: Ints) -> tuple[Ints, Ints, Ints]:
        """Return the indices along x, y and z of lattice points."""
        across, z = np.divmod(places.astype(self.number, copy=False), self.shape[2])
        x, y = np.divmod(across, self.shape[1])
        return x, y, z


_LARGEST_TABLE = 2**25
"""Entries of a look-up table, at the most: 5 bytes each, 168 MB; larger lattices are sorted, which is slower."""


def welded(corners: Ints, possible: int) -> tuple[Ints, NDArray[np.int32]]:
    """Return the unique numbers below `possible` in order, and the index among them of each corner."""
    # A table with an entry per lattice point is linear; if it is mostly empty, more than 64 per corner, sorting is
    # faster.
    if possible > min(64 * corners.size, _LARGEST_TABLE):
        points, indices = np.unique(corners, return_inverse=True)
        return points, indices.reshape(corners.shape).astype(np.int32)
    used = np.zeros(possible, dtype=bool)
    used[corners] = True
    points = np.flatnonzero(used)
    index_of = np.empty(possible, dtype=np.int32)
    index_of[points] = np.arange(len(points), dtype=np.int32)
    return points, index_of.take(corners)


class LabelGrid(NamedTuple):
    """Labels (n_x + 2, n_y + 2) of a window's cells and a border: rank * materials + material; 0 is the ground.

    A rank is the index of a height among the lattice's z lines; a material is 0 for a frame, else the level.
    """

    labels: Ints
    materials: int
    lattice: VertexGrid

    @property
    def cells(self) -> Ints:
        """Labels of the window without the border."""
        return self.labels[1:-1, 1:-1]


def label_grid(field: StepField, window: CellWindow | None = None) -> LabelGrid:
    """Return the label grid of a field, or of a window of it; outside the field is ground."""
    cells_x, cells_y = window or field.whole
    seen = slice(max(cells_x.start - 1, 0), cells_x.stop + 1), slice(max(cells_y.start - 1, 0), cells_y.stop + 1)
    # Only levels that occur have a rank, so that labels stay small on maps of few, high levels.
    levels, frame = field.levels[seen], field.frame[seen]
    known = np.flatnonzero(np.bincount(levels.ravel()))
    heights = np.round(known * field.unit, NANOMETRE_DIGITS)
    frame_height = round(field.frame_height, NANOMETRE_DIGITS) if frame.any() else 0.0
    tops = np.array(sorted({0.0, frame_height, *heights.tolist()}))
    materials = int(known[-1]) + 1
    label_of: Ints = np.zeros(materials, dtype=np.int32 if len(tops) * materials < 2**30 else np.int64)
    label_of[known] = np.searchsorted(tops, heights) * materials + known
    label_of[0] = 0
    labels: Ints = label_of[levels]
    labels[frame] = np.searchsorted(tops, frame_height) * materials
    # The cells that are seen, on a border of ground, where the field ends at the window.
    around = np.zeros([part.stop - part.start + 2 for part in (cells_x, cells_y)], dtype=labels.dtype)
    x, y = (part.start - cells.start + 1 for part, cells in zip(seen, (cells_x, cells_y), strict=True))
    around[x : x + labels.shape[0], y : y + labels.shape[1]] = labels
    edges_x, edges_y = field.edges()
    lines = edges_x[cells_x.start : cells_x.stop + 1], edges_y[cells_y.start : cells_y.stop + 1], tops
    return LabelGrid(around, materials, VertexGrid(lines=lines))


def split_window(window: CellWindow, side: int) -> Iterator[CellWindow]:
    """Yield the parts of a window, of at most `side` x `side` cells, from the corner of smallest x and y on."""
    for x in range(window[0].start, window[0].stop, side):
        for y in range(window[1].start, window[1].stop, side):
            yield slice(x, min(x + side, window[0].stop)), slice(y, min(y + side, window[1].stop))
