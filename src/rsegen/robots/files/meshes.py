"""Meshes of robots in files: COLLADA (.dae) and binary STL are read by rsegen itself, all others by trimesh.

A robot may have hundreds of binary STL files, of which trimesh takes ten times as long: it guesses the encoding of the
header, and copies all three times. Of a mesh of many faces, such as a scan of a robot, fewer are measured and drawn.
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
from rsegen.geometry.mesh_files import (
    MAX_MESH_MIB,
    STL_FACE,
    Triangles,
    binary_faces,
    loaded_by_trimesh,
    read_collada,
)
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
                if len(corners) > MANY_FACES:  # whose equal corners would be merged for longer than all the rest takes
                    return _separate(corners)
                mesh: Any = trimesh.Trimesh(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))
            else:
                refuse_large(path, os.fstat(file.fileno()).st_size)
                mesh = loaded_by_trimesh(path, file, force="mesh")
        if not len(mesh.faces):
            raise FileError(f"{path}: has no triangles")
        return Triangles(np.asarray(mesh.vertices), np.asarray(mesh.faces))

    return read_by_library(path, triangles)


def collision_mesh(path: Path) -> Triangles:
    """Return the triangles of the mesh of a collision shape, metres; FileError if it cannot be read."""
    try:
        return read_mesh(path)
    except ImportError:
        problem = "the mesh of a collision shape is read by trimesh, which is not installed"
        raise FileError(f"{path}: {problem}") from None


def _separate(corners: Array) -> Triangles:
    """Return triangles of which none share a point, from their corners (n, 3, 3); without those that have no place."""
    corners = corners[np.isfinite(corners).all(axis=(1, 2))]
    return Triangles(corners.reshape(-1, 3).astype(np.float64), np.arange(3 * len(corners)).reshape(-1, 3))


MANY_FACES = 200_000
"""Faces of a mesh from which on it may be simplified; MuJoCo reads no more of an STL file."""

_MOST_CUBES = 2.0**62
"""Cubes that can be counted in integers of 64 bits."""

_CUBES_PER_POINT = 2
"""Cubes up to which an array of all of them is quicker than sorting points by their cubes."""


def simplified(mesh: Triangles, side: float) -> Triangles:
    """Return a mesh of many faces with one of its points in each cube, that farthest from its middle; others as given.

    By vertex clustering (Rossignac and Borrel 1993): a face between three cubes stays, and one within fewer is left
    out. Nothing moves by more than the diagonal of a cube, and what is outermost by far less; parts that are thinner
    than a cube have all their faces. side: of a cube, metres.
    """
    points, corners = mesh
    if len(corners) <= MANY_FACES or not side > 0:
        return mesh
    # The index of each point's cube in an array of the shape `cubes`, and the point's squared distance from the middle.
    low, high = bounds(points)
    cubes = np.floor((high - low) / side) + 1
    count = float(np.prod(cubes))
    if not count < _MOST_CUBES:  # such as a corner that is far away by mistake, or no number
        return mesh
    cube, away = np.zeros(len(points), np.int64), np.zeros(len(points))
    for axis, column in enumerate(points.T):
        cube = cube * int(cubes[axis]) + ((column - low[axis]) / side).astype(np.int64)
        away += (column - (low[axis] + high[axis]) / 2) ** 2
    # Most cubes of a wide mesh are empty: then those with points are numbered anew.
    if count > _CUBES_PER_POINT * len(points):
        different, cube = np.unique(cube, return_inverse=True)
        count = len(different)
    # The farthest point of each cube, of several the first, becomes the point for all corners in the cube.
    farthest = np.full(int(count), -1.0)
    np.maximum.at(farthest, cube, away)
    chosen = np.flatnonzero(away == farthest[cube])[::-1]
    new_index, first = np.full(len(farthest), -1), np.full(len(farthest), -1)
    first[cube[chosen]] = chosen  # the last that is written is the first of them
    filled = np.flatnonzero(first >= 0)
    new_index[filled] = np.arange(len(filled))
    faces = new_index[cube[corners]]
    a, b, c = faces.T
    stays = (a != b) & (b != c) & (c != a)
    # A thin part has no face between three cubes: its faces are added as they were, with corners of their own.
    thin = np.ones(len(filled), bool)
    thin[faces[stays]] = False
    as_given = points[corners[~stays & thin[faces].any(axis=1)]].reshape(-1, 3)
    every = np.concatenate([points[first[filled]], as_given])
    return Triangles(every, np.concatenate([faces[stays], np.arange(len(filled), len(every)).reshape(-1, 3)]))


def refuse_large(path: Path, size: int, advice: str = "") -> None:
    """Raise a FileError for a file of a mesh of too many bytes; binary STL files may have more.

    advice: what to do instead of writing such a file
    """
    if size > MAX_MESH_MIB << 20:
        why = f"larger than {MAX_MESH_MIB} MiB, too large for a mesh of a robot"
        advice = advice or f"simplify it, or write it as binary STL, of up to {_MAX_STL_MIB} MiB"
        raise FileError(f"{path}: {why}; {advice}")


def mesh_corners(path: Path) -> Array:
    """Return the corners of the triangles of a mesh, (n, 3), metres; errors as of `read_mesh`.

    Of a binary STL file as they stand there, as merging them costs most.
    """
    corners = None
    if path.suffix.lower() == ".stl" and find_spec("trimesh"):
        with suppress(OSError), open_regular(path) as file:
            corners = _of_binary_stl(path, file)
    if corners is None or not len(corners) or not np.isfinite(corners).all():
        points, faces = read_mesh(path)
        corners = points[faces]
    return np.asarray(corners).reshape(-1, 3)


def simplified_to(mesh: Triangles, parts: int) -> Triangles:
    """Return a mesh of many faces simplified to cubes, `parts` of them along its diagonal; others as given."""
    low, high = bounds(mesh.points)
    return simplified(mesh, float(np.linalg.norm(high - low)) / parts)


def bounds(points: Array) -> tuple[Array, Array]:
    """Return the lowest and the highest place of points (n, 3), axis by axis: a sixth of the time of all at once."""
    low, high = (np.array([least(column) for column in points.T]) for least in (np.min, np.max))
    return low, high


_MAX_STL_MIB = 256
"""The largest binary STL file that is read, MiB: 5 million faces."""


def _of_binary_stl(path: Path, file: IO[bytes]) -> Array | None:
    """Return the corners of the triangles of an open STL file, (n, 3, 3); None of one that is not binary."""
    if path.suffix.lower() != ".stl" or os.fstat(file.fileno()).st_size > _MAX_STL_MIB << 20:
        return None
    if binary_faces(file) is None:
        file.seek(0)
        return None
    return np.frombuffer(file.read(), STL_FACE)["corners"]
