"""trimesh: a box object for each block, and all boxes at once as numpy arrays."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from benchmarks.grids import BLOCK, Levels


def one_by_one(levels: Levels, path: Path) -> int:
    """`creation.box` for each block, joined and exported."""
    found = []
    for (i, j), level in np.ndenumerate(levels):
        place = np.eye(4)
        place[:3, 3] = (i + 0.5) * BLOCK, (j + 0.5) * BLOCK, level * BLOCK / 2
        found.append(trimesh.creation.box((BLOCK, BLOCK, level * BLOCK), place))
    return exported(trimesh.util.concatenate(found), path)


def at_once(levels: Levels, path: Path) -> int:
    """All boxes as two arrays, exported in the format that the file's ending says."""
    unit = trimesh.creation.box(bounds=((0, 0, 0), (1, 1, 1)))
    i, j = np.indices(levels.shape)
    low = np.stack([i.ravel(), j.ravel(), np.zeros(levels.size)], axis=1) * BLOCK
    size = np.stack(np.broadcast_arrays(BLOCK, BLOCK, levels.ravel() * BLOCK), axis=1)
    vertices = low[:, None] + unit.vertices * size[:, None]
    faces = unit.faces + 8 * np.arange(levels.size)[:, None, None]
    return exported(trimesh.Trimesh(vertices.reshape(-1, 3), faces.reshape(-1, 3), process=False), path)


def exported(mesh: Any, path: Path) -> int:
    """Write a trimesh as its users do; its triangles. Its own types say too little of it."""
    mesh.export(path)
    return len(mesh.faces)
