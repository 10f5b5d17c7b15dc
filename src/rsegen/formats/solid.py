"""A watertight mesh that stays watertight when a program merges equal vertices, for stl, ply, glb and usd.

STL has no vertex indices, and importers of the others merge vertices at one position. Where two blocks touch only along
a vertical edge, four faces would then meet in it. So the faces of one of the blocks are bisected there:

         |         |
         |         *      the edges of the two blocks then have different ends,
         |         |      and each of them has two faces
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rsegen.field.stepfield import Array, Ints, Mask, StepField
from rsegen.geometry import TILES, texture_coordinates, watertight


class Solid(NamedTuple):
    """A mesh: vertices (n, 3) in metres, z up; triangles (m, 3), counterclockwise from outside; materials (m,).

    sides: (m,) and coordinates: (m, 3, 2), the texture and the texture coordinates of the corners, in images; without
    textures these are (m, 3, 0).
    """

    vertices: Array
    triangles: Ints
    materials: Ints
    sides: Mask
    coordinates: Array

    @property
    def mesh(self) -> Any:
        """Mesh as a trimesh.Trimesh, not processed."""
        import trimesh

        return trimesh.Trimesh(self.vertices, self.triangles, process=False)

    def part(self, which: Mask) -> Solid:
        """Return the mesh of the triangles in a mask (m,), with vertices of its own."""
        used, corners = np.unique(self.triangles[which], return_inverse=True)
        own = self.materials[which], self.sides[which], self.coordinates[which]
        return Solid(self.vertices[used], corners.reshape(-1, 3), *own)


def solid(field: StepField, *, textured: bool = False) -> Solid:
    """Return the watertight mesh of a field, which stays watertight when vertices at one position are merged.

    If two blocks touch only along a vertical edge, four faces meet in it. One of the two blocks has an additional
    vertex in the middle of that edge: so no edge between two vertices has more than two faces, and no point has moved.
    """
    # An edge has two numbers: `own` by its vertices, `edge` by its position. Where several have one position, all are
    # bisected but the one of the lowest number.
    mesh = watertight(field)
    edges = mesh.triangles[:, [[0, 1], [1, 2], [2, 0]]]
    own = _numbered(edges, len(mesh.places))
    places = np.unique(mesh.places, axis=0, return_inverse=True)[1].ravel()
    edge = np.unique(_numbered(places[edges], len(places)), return_inverse=True)[1].reshape(own.shape)
    lowest = np.full(own.size, np.iinfo(np.int64).max)
    np.minimum.at(lowest, edge, own)
    sides, coordinates = np.zeros(len(mesh.triangles), dtype=bool), np.zeros((len(mesh.triangles), 3, 0))
    if textured:
        texture = texture_coordinates(mesh, field)
        sides, coordinates = texture.sides, texture.values[texture.corners] / TILES
    closed = Solid(mesh.vertices, mesh.triangles, mesh.materials, sides, coordinates)
    return _bisected(closed, own, own != lowest[edge])


def _numbered(edges: Ints, count: int) -> Ints:
    """Return a number (m, 3) per undirected edge (m, 3, 2)."""
    ends = np.sort(edges, axis=2).astype(np.int64)
    return ends[..., 0] * count + ends[..., 1]


def _bisected(mesh: Solid, edges: Ints, chosen: Ints) -> Solid:
    """Return the mesh with triangles bisected at the chosen edges: vertical ones, of which no triangle has two."""
    # Both triangles at an edge are cut, and share its middle; the halves are after all others, in this order.
    cut, side = np.nonzero(chosen)
    start, end = (mesh.triangles[cut, (side + step) % 3] for step in range(2))
    known, first, edge = np.unique(edges[cut, side], return_index=True, return_inverse=True)
    middles = (mesh.vertices[start[first]] + mesh.vertices[end[first]]) / 2
    vertices = np.concatenate([mesh.vertices, middles.reshape(len(known), 3)])
    triangles = _halved(mesh.triangles, cut, side, len(mesh.vertices) + edge.ravel())
    faces = np.concatenate([np.delete(np.arange(len(mesh.triangles)), cut), cut, cut])
    between = (mesh.coordinates[cut, side] + mesh.coordinates[cut, (side + 1) % 3]) / 2
    coordinates = _halved(mesh.coordinates, cut, side, between)
    return Solid(vertices, triangles, mesh.materials[faces], mesh.sides[faces], coordinates)


def _halved(corners: NDArray[Any], cut: Ints, side: Ints, middle: NDArray[Any]) -> NDArray[Any]:
    """Return values at the corners (m, 3, ...) of all triangles after those in `cut` were bisected: these come last."""
    start, end, tip = (corners[cut, (side + step) % 3] for step in range(3))
    halves = [np.stack(parts, axis=1) for parts in ((start, middle, tip), (middle, end, tip))]
    return np.concatenate([np.delete(corners, cut, axis=0), *halves])
