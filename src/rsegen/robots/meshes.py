"""Meshes of robots in files: COLLADA (.dae) and binary STL are read by rsegen itself, all others by trimesh.

A robot may have hundreds of binary STL files, of which trimesh takes ten times as long: it guesses the encoding of the
header, and copies all three times.
"""

from __future__ import annotations

import os
from base64 import urlsafe_b64decode, urlsafe_b64encode
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path
from typing import IO, Any

import numpy as np

from rsegen.errors import FileError
from rsegen.field.stepfield import Array
from rsegen.geometry.collada import MAX_MESH_MIB, Triangles, read_collada
from rsegen.input_files import open_regular, read_by_library

SUFFIXES = (".stl", ".obj", ".ply", ".glb", ".gltf", ".dae")
"""Endings of the files of meshes that are measured."""

INLINE = "data:triangles;base64,"
"""Begin of the URI of a mesh whose triangles stand in the model itself: in base64, how many points there are, then
points and corners, numbers of four bytes."""


def inline_uri(mesh: Triangles) -> str:
    """Return the URI of a mesh that has no file."""
    count, points, corners = np.uint32(len(mesh.points)), mesh.points.astype("<f4"), mesh.corners.astype("<u4")
    return INLINE + urlsafe_b64encode(count.tobytes() + points.tobytes() + corners.tobytes()).decode()


def _inline(uri: str) -> Triangles:
    content = urlsafe_b64decode(uri.removeprefix(INLINE))
    end = 4 + 12 * int.from_bytes(content[:4], "little")
    points = np.frombuffer(content[4:end], "<f4").reshape(-1, 3).astype(np.float64)
    corners = np.frombuffer(content[end:], "<u4").reshape(-1, 3).astype(np.int64)
    if not (corners.size and corners.max() < len(points) and np.isfinite(points).all()):
        raise ValueError("a corner of a triangle is no point")
    return Triangles(points, corners)


def read_mesh(path: Path) -> Triangles:
    """Return the triangles of a mesh, metres; FileError if it cannot be read, ImportError if trimesh is missing."""
    if (uri := str(path)).startswith(INLINE):
        return read_by_library(Path("a mesh in the model itself"), lambda: _inline(uri))
    if path.suffix.lower() == ".dae":
        return read_collada(path)

    def triangles() -> Triangles:
        import trimesh

        with open_regular(path) as file:
            if (corners := _of_binary_stl(path, file)) is not None:
                mesh: Any = trimesh.Trimesh(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))
            else:
                refuse_large(path, os.fstat(file.fileno()).st_size)
                form, resolver = path.suffix[1:].lower(), trimesh.resolvers.FilePathResolver(str(path))
                mesh = trimesh.load(file, file_type=form, resolver=resolver, force="mesh")
        if not len(mesh.faces):
            raise FileError(f"{path}: has no triangles")
        return Triangles(np.asarray(mesh.vertices), np.asarray(mesh.faces))

    return read_by_library(path, triangles)


def refuse_large(path: Path, size: int, advice: str = "") -> None:
    """Raise a FileError for a file of a mesh of too many bytes; binary STL files may have more.

    advice: what to do instead of writing such a file
    """
    if size > MAX_MESH_MIB << 20:
        why = f"larger than {MAX_MESH_MIB} MiB, too large for a mesh of a robot"
        advice = advice or f"simplify it, or write it as binary STL, of up to {_MAX_STL_MIB} MiB"
        raise FileError(f"{path}: {why}; {advice}")


def mesh_bounds(path: Path) -> tuple[Array, Array]:
    """Return the lowest and the highest place of the triangles of a mesh, (3,) each, metres; errors as of `read_mesh`.

    Of a binary STL file without merging its corners, which costs most.
    """
    corners = None
    if path.suffix.lower() == ".stl" and find_spec("trimesh"):
        with suppress(OSError), open_regular(path) as file:
            corners = _of_binary_stl(path, file)
    if corners is None or not len(corners) or not np.isfinite(corners).all():
        points, faces = read_mesh(path)
        corners = points[faces]
    places = np.asarray(corners, dtype=np.float64).reshape(-1, 3).T
    return places.min(axis=1), places.max(axis=1)


_MAX_STL_MIB = 256
"""The largest binary STL file that is read, MiB: 5 million faces."""

_HEADER, _FACE = 84, np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
"""Bytes before the faces of a binary STL file, the last four of which are their number; and a face."""


def _of_binary_stl(path: Path, file: IO[bytes]) -> Array | None:
    """Return the corners of the triangles of an open STL file, (n, 3, 3); None of one that is not binary."""
    if path.suffix.lower() != ".stl" or os.fstat(file.fileno()).st_size > _MAX_STL_MIB << 20:
        return None
    if binary_faces(file) is None:
        file.seek(0)
        return None
    return np.frombuffer(file.read(), _FACE)["corners"]


def binary_faces(file: IO[bytes]) -> int | None:
    """Return the number of faces that follow in an open STL file; None of one that is not binary, or is cut."""
    count = int.from_bytes(file.read(_HEADER)[-4:], "little")
    return count if os.fstat(file.fileno()).st_size == _HEADER + count * _FACE.itemsize else None
