"""Meshes of robots in files: COLLADA (.dae) is read by rsegen itself, all others by trimesh."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from rsegen.errors import FileError
from rsegen.geometry.collada import Triangles, read_collada
from rsegen.input_files import open_regular, read_by_library

SUFFIXES = (".stl", ".obj", ".ply", ".glb", ".gltf", ".dae")
"""Endings of the files of meshes that are measured."""


def read_mesh(path: Path) -> Triangles:
    """Return the triangles of a mesh, metres; FileError if it cannot be read, ImportError if trimesh is missing."""
    if path.suffix.lower() == ".dae":
        return read_collada(path)

    def triangles() -> Triangles:
        import trimesh

        with open_regular(path) as file:
            form, resolver = path.suffix[1:].lower(), trimesh.resolvers.FilePathResolver(str(path))
            mesh: Any = trimesh.load(file, file_type=form, resolver=resolver, force="mesh")
        if not len(mesh.faces):
            raise FileError(f"{path}: has no triangles")
        return Triangles(np.asarray(mesh.vertices), np.asarray(mesh.faces))

    return read_by_library(path, triangles)
