"""A mesh of rectangles that stand along the axes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rsegen.stepfield import Array

NORMALS = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1]])
"""The directions that a face may look in: +x, -x, +y, -y, +z."""


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Mesh:
    """Welded vertices (n, 3) in metres, and rectangles (m, 4) of vertex numbers, counterclockwise seen from outside.

    normals: (m,) row of NORMALS for each face; materials: (m,) 0 for a frame, else the level whose block it belongs to.
    Faces are in the order of their materials.
    """

    vertices: Array
    faces: NDArray[np.int32]
    normals: NDArray[np.int8]
    materials: NDArray[np.int16]

    def __post_init__(self) -> None:
        for array in (self.vertices, self.faces, self.normals, self.materials):
            array.setflags(write=False)

    @property
    def triangles(self) -> NDArray[np.int32]:
        """Every rectangle cut in two: (2 m, 3)."""
        return self.faces[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
