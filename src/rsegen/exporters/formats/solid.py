"""A watertight mesh that stays watertight when a program merges equal vertices, for stl, ply, glb and usd."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from rsegen.field.stepfield import Array, Ints, StepField
from rsegen.geometry import watertight

BYTES_A_CELL = 6000
"""The memory per cell for a watertight mesh and trimesh's copies of it."""


class Solid(NamedTuple):
    """A mesh: vertices (n, 3) in metres, z up; triangles (m, 3), counterclockwise from outside; materials (m,)."""

    vertices: Array
    triangles: Ints
    materials: Ints

    @property
    def mesh(self) -> Any:
        """The mesh as a trimesh.Trimesh, not processed."""
        import trimesh

        return trimesh.Trimesh(self.vertices, self.triangles, process=False)

    def parts(self) -> Iterator[tuple[int, Solid]]:
        """Each material with the mesh of its triangles, which has vertices of its own."""
        for material in np.unique(self.materials).tolist():
            yield material, self.of([material])

    def of(self, materials: Sequence[int]) -> Solid:
        """The mesh of the triangles of these materials, with vertices of its own."""
        chosen = np.isin(self.materials, materials)
        used, corners = np.unique(self.triangles[chosen], return_inverse=True)
        return Solid(self.vertices[used], corners.reshape(-1, 3), self.materials[chosen])


def solid(field: StepField) -> Solid:
    """The watertight mesh of a field, which stays watertight when vertices at one position are merged.

    If two blocks touch only along a vertical edge, four faces meet in it. One of the two blocks has an additional
    vertex in the middle of that edge: so no edge between two vertices has more than two faces, and no point has moved.
    """
    mesh = watertight(field)
    edges = mesh.triangles[:, [[0, 1], [1, 2], [2, 0]]]
    own = _numbered(edges, len(mesh.places))
    places = np.unique(mesh.places, axis=0, return_inverse=True)[1].ravel()
    edge = np.unique(_numbered(places[edges], len(places)), return_inverse=True)[1].reshape(own.shape)
    lowest = np.full(own.size, np.iinfo(np.int64).max)
    np.minimum.at(lowest, edge, own)
    return _bisected(Solid(mesh.vertices, mesh.triangles, mesh.materials), own, own != lowest[edge])


def _numbered(edges: Ints, count: int) -> Ints:
    """One number (m, 3) per undirected edge (m, 3, 2)."""
    ends = np.sort(edges, axis=2).astype(np.int64)
    return ends[..., 0] * count + ends[..., 1]


def _bisected(found: Solid, edges: Ints, chosen: Ints) -> Solid:
    """The mesh with triangles bisected at the chosen edges; these are vertical, so no triangle has two of them."""
    cut, side = np.nonzero(chosen)
    start, end, tip = (found.triangles[cut, (side + step) % 3] for step in range(3))
    known, first, number = np.unique(edges[cut, side], return_index=True, return_inverse=True)
    middle = len(found.vertices) + number.ravel()
    middles = (found.vertices[start[first]] + found.vertices[end[first]]) / 2
    whole = np.delete(np.arange(len(found.triangles)), cut)
    halves = [np.stack(corners, axis=1) for corners in ((start, middle, tip), (middle, end, tip))]
    return Solid(
        np.concatenate([found.vertices, middles.reshape(len(known), 3)]),
        np.concatenate([found.triangles[whole], *halves]),
        found.materials[np.concatenate([whole, cut, cut])],
    )
