"""A mesh whose faces are perpendicular to the axes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rsegen.field.stepfield import Array, Mask

NORMALS = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]])
"""The normals that a face can have: +x, -x, +y, -y, +z, -z."""


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Mesh:
    """Faces (m, 4) or (m, 3) of vertex numbers, counterclockwise seen from outside, sorted by material.

    lines: the distinct x, y and z coordinates of vertices, metres; places: (n, 3), the indices of each vertex in them.
    normals: (m,) row of NORMALS of each face; materials: (m,) 0 for a frame, else the level of the block.
    """

    lines: tuple[Array, Array, Array]
    places: NDArray[np.int32]
    faces: NDArray[np.int32]
    normals: NDArray[np.int8]
    materials: NDArray[np.int16]

    def __post_init__(self) -> None:
        for array in (*self.lines, self.places, self.faces, self.normals, self.materials):
            array.setflags(write=False)

    @property
    def vertices(self) -> Array:
        """Coordinates of the vertices, (n, 3), metres."""
        return np.stack([line[at] for line, at in zip(self.lines, self.places.T, strict=True)], axis=1)

    @property
    def triangles(self) -> NDArray[np.int32]:
        """The faces as triangles: (2 m, 3), or (m, 3) if the faces are triangles."""
        return self.faces if self.faces.shape[1] == 3 else self.faces[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)

    def part(self, which: Mask) -> Mesh:
        """The mesh of the faces in a mask (m,), with the vertices that they use."""
        used, corners = np.unique(self.faces[which], return_inverse=True)
        return replace(
            self,
            places=self.places[used],
            faces=corners.reshape(-1, self.faces.shape[1]).astype(np.int32),
            normals=self.normals[which],
            materials=self.materials[which],
        )
