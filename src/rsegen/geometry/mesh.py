"""A mesh of faces that stand along the axes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rsegen.field.stepfield import Array, Mask

NORMALS = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]])
"""The directions that a face may look in: +x, -x, +y, -y, +z, -z."""


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Mesh:
    """Faces (m, 4) or (m, 3) of vertex numbers, counterclockwise seen from outside, in the order of their materials.

    lines: the few different x, y and z that vertices have, metres; places: (n, 3) where in them each vertex is.
    normals: (m,) row of NORMALS for each face; materials: (m,) 0 for a frame, else the level whose block it belongs to.
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
        """(n, 3), metres."""
        return np.stack([line[at] for line, at in zip(self.lines, self.places.T, strict=True)], axis=1)

    @property
    def triangles(self) -> NDArray[np.int32]:
        """Every face cut in triangles: (2 m, 3), or (m, 3) where they are triangles already."""
        return self.faces if self.faces.shape[1] == 3 else self.faces[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)

    def part(self, which: Mask) -> Mesh:
        """Some of its faces, (m,), with the vertices that these use."""
        used, corners = np.unique(self.faces[which], return_inverse=True)
        return replace(
            self,
            places=self.places[used],
            faces=corners.reshape(-1, self.faces.shape[1]).astype(np.int32),
            normals=self.normals[which],
            materials=self.materials[which],
        )
