"""Wavefront OBJ and MTL: the mesh format that both Gazebos load fastest.

Absolute indices, one normal for each face (a file without normals crashes Gazebo Sim), one group for each material.
Coordinates come from few distinct numbers and indices from a count, so each text is made once and gathered as bytes.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from rsegen.export.numbers import decimal
from rsegen.geometry import NORMALS, Mesh
from rsegen.scene import Scene

_Texts = NDArray[np.bytes_]

STRIP = 2**16
"""Lines that are made at once: enough to be quick, few enough to need no memory to speak of."""


def obj(mesh: Mesh, mtl_name: str) -> Iterator[bytes]:
    """The OBJ file of a mesh, whose colours are in the file `mtl_name` beside it."""
    yield f"# metres, z up; made by rsegen\nmtllib {mtl_name}\n".encode()
    yield from _vertices(mesh)
    yield "".join(f"vn {x} {y} {z}\n" for x, y, z in NORMALS).encode()
    yield from _faces(mesh)


def mtl(scene: Scene) -> Iterator[bytes]:
    """The MTL file of every colour that a map of the scene's recipe can have."""
    for material in range(scene.recipe.top_level + 1):
        red, green, blue = map(decimal, scene.colour(material))
        colour = f"{red} {green} {blue}"
        yield f"newmtl {material_name(material)}\nKa {colour}\nKd {colour}\nKs 0 0 0\nd 1\nillum 1\n".encode()


def material_name(material: int) -> str:
    """What OBJ and MTL call a material: 0 is the frame, any other the level."""
    return f"level_{material}" if material else "frame"


def _vertices(mesh: Mesh) -> Iterator[bytes]:
    axes = [np.unique(column, return_inverse=True) for column in mesh.vertices.T]
    texts = [np.array([decimal(value) for value in values.tolist()], dtype="S") for values, _ in axes]
    for strip in _strips(0, len(mesh.vertices)):
        x, y, z = (text[numbers[strip]] for text, (_, numbers) in zip(texts, axes, strict=True))
        yield _lines([b"v ", x, b" ", y, b" ", z, b"\n"], len(x))


def _faces(mesh: Mesh) -> Iterator[bytes]:
    """A group for each material, in whose order the faces are."""
    numbers = np.arange(1, len(mesh.vertices) + 1).astype("S")
    normals = np.array([f"//{number + 1}" for number in range(len(NORMALS))], dtype="S")
    for material in np.unique(mesh.materials):
        name = material_name(int(material))
        yield f"g {name}\nusemtl {name}\n".encode()
        for strip in _strips(*np.searchsorted(mesh.materials, [material, material + 1]).tolist()):
            a, b, c, d = (numbers[mesh.faces[strip, corner]] for corner in range(4))
            n = normals[mesh.normals[strip]]
            yield _lines([b"f ", a, n, b" ", b, n, b" ", c, n, b" ", d, n, b"\n"], len(n))


def _strips(start: int, stop: int) -> Iterator[slice]:
    return (slice(low, min(low + STRIP, stop)) for low in range(start, stop, STRIP))


def _lines(parts: Sequence[_Texts | bytes], count: int) -> bytes:
    """`count` lines: in each the texts of all parts, one after the other; a part of bytes is the same in every line."""
    columns = [
        np.broadcast_to(np.frombuffer(part, np.uint8), (count, len(part)))
        if isinstance(part, bytes)
        else part.view(np.uint8).reshape(count, -1)
        for part in parts
    ]
    page = np.concatenate(columns, axis=1)
    written: bytes = page[page != 0].tobytes()
    return written
