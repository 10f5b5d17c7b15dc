"""The closed surface of a map as programs read it that weld equal corners: what stl, ply and glb are made of."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from rsegen.field.stepfield import Array, Ints, StepField
from rsegen.geometry import watertight

BYTES_A_CELL = 6000
"""Of memory while a closed surface is made and written: its triangles, and trimesh's copies of them."""


class Solid(NamedTuple):
    """vertices (n, 3) metres, z up; triangles (m, 3) of them, counterclockwise seen from outside; materials (m,)."""

    vertices: Array
    triangles: Ints
    materials: Ints

    @property
    def mesh(self) -> Any:
        """It as it is, as a trimesh.Trimesh."""
        import trimesh

        return trimesh.Trimesh(self.vertices, self.triangles, process=False)

    def parts(self) -> Iterator[tuple[int, Solid]]:
        """Of each material what has it, with vertices of its own."""
        for material in np.unique(self.materials).tolist():
            of_it = self.materials == material
            used, corners = np.unique(self.triangles[of_it], return_inverse=True)
            yield material, Solid(self.vertices[used], corners.reshape(-1, 3), self.materials[of_it])


def solid(field: StepField) -> Solid:
    """The closed surface of a field, which stays closed where vertices at one place are welded.

    Where two blocks touch along a vertical edge alone, four faces meet in it. One of the two blocks has a vertex more
    in the middle of that edge: so no edge between two vertices has more than two faces, and nothing has moved.
    """
    mesh = watertight(field)
    edges = mesh.triangles[:, [[0, 1], [1, 2], [2, 0]]]
    own = _numbered(edges, len(mesh.places))
    places = np.unique(mesh.places, axis=0, return_inverse=True)[1].ravel()
    edge = np.unique(_numbered(places[edges], len(places)), return_inverse=True)[1].reshape(own.shape)
    lowest = np.full(own.size, np.iinfo(np.int64).max)
    np.minimum.at(lowest, edge, own)
    return _halved(Solid(mesh.vertices, mesh.triangles, mesh.materials), own, own != lowest[edge])


def _numbered(edges: Ints, count: int) -> Ints:
    """One number (m, 3) for the two ends of each edge (m, 3, 2), whichever comes first."""
    ends = np.sort(edges, axis=2).astype(np.int64)
    return ends[..., 0] * count + ends[..., 1]


def _halved(found: Solid, edges: Ints, chosen: Ints) -> Solid:
    """Triangles cut in two from the middle of an edge; no triangle has two of those, which are all vertical."""
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
