"""Wavefront OBJ and MTL files, the mesh format that both Gazebos load fastest.

Absolute indices, one normal per face (a file without normals crashes Gazebo Sim), one group per material. There are few
distinct coordinates, and indices are consecutive, so each number is formatted once and gathered as bytes.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from rsegen.exporters.numbers import decimal
from rsegen.exporters.scene import Scene
from rsegen.field.stepfield import Ints
from rsegen.geometry import NORMALS, Mesh

_Texts = NDArray[np.void]
"""Texts of one width, padded with zero bytes, as items of that many bytes."""

STRIP = 2**15
"""Lines that are made at once: enough to be fast, few enough to stay in the CPU cache."""


def obj(meshes: Iterable[Mesh], mtl_name: str) -> Iterator[bytes]:
    """The OBJ file of meshes, one after the other, with the colours of the file `mtl_name` in the same folder."""
    yield f"# metres, z up; made by rsegen\nmtllib {mtl_name}\n".encode()
    yield "".join(f"vn {x} {y} {z}\n" for x, y, z in NORMALS).encode()
    vertices = 0
    for mesh in meshes:
        yield from _vertices(mesh)
        yield from _faces(mesh, vertices + 1)
        vertices += len(mesh.places)


def face_count(piece: bytes) -> int:
    """The number of faces in a chunk of an OBJ file."""
    return piece.count(b"\nf ") + piece.startswith(b"f ")


def mtl(scene: Scene) -> Iterator[bytes]:
    """The MTL file with every colour that maps of the scene's recipe can have."""
    for material in range(scene.recipe.highest_level + 1):
        red, green, blue = map(decimal, scene.colour(material))
        colour = f"{red} {green} {blue}"
        yield f"newmtl {material_name(material)}\nKa {colour}\nKd {colour}\nKs 0 0 0\nd 1\nillum 1\n".encode()


def material_name(material: int) -> str:
    """The name of a material in OBJ and MTL: `frame` for 0, `level_N` for any other number."""
    return f"level_{material}" if material else "frame"


def _vertices(mesh: Mesh) -> Iterator[bytes]:
    texts = [_texts([f" {decimal(value)}" for value in line.tolist()]) for line in mesh.lines]
    for strip in _strips(0, len(mesh.places)):
        columns = [text[at] for text, at in zip(texts, mesh.places[strip].T, strict=True)]
        yield _bare(_page([b"v", *columns, b"\n"], len(columns[0])))


def _faces(mesh: Mesh, first: int) -> Iterator[bytes]:
    """The faces, one group per material; `first` is the number of the first vertex."""
    numbers = _counted(first, len(mesh.places))
    normals = _texts([f"//{number + 1}" for number in range(len(NORMALS))])
    before = -1
    for strip in _strips(0, len(mesh.faces)):
        normal = normals[mesh.normals[strip]]
        corners = [part for corner in mesh.faces[strip].T for part in (b" ", numbers[corner], normal)]
        page = _page([b"f", *corners, b"\n"], len(normal))
        for material, lines in _groups(mesh.materials[strip]):
            if material != before:
                name = material_name(material)
                yield f"g {name}\nusemtl {name}\n".encode()
            yield _bare(page[lines])
            before = material


def _groups(materials: Ints) -> Iterator[tuple[int, slice]]:
    """Each material and the slice of faces that have it."""
    changes = np.flatnonzero(materials[1:] != materials[:-1]) + 1
    for low, high in pairwise([0, *changes.tolist(), len(materials)]):
        yield int(materials[low]), slice(low, high)


def _strips(start: int, stop: int) -> Iterator[slice]:
    return (slice(low, min(low + STRIP, stop)) for low in range(start, stop, STRIP))


def _texts(texts: Sequence[str]) -> _Texts:
    plain = np.array(texts, dtype="S")
    return plain.view(f"V{plain.itemsize}")


def _counted(first: int, count: int) -> _Texts:
    """The texts of the numbers from `first` on, put together from texts of four digits each."""
    numbers = np.arange(first, first + count)
    if first + count > 10**8:
        return _texts(numbers.astype("S").tolist())
    high, low = np.divmod(numbers.astype(np.int32), 10_000)
    halves = np.stack([_BARE[high], np.where(high > 0, _PADDED[low], _BARE[low])], axis=1)
    return halves.reshape(-1).view("V8")


_PADDED = np.array([f"{number:04d}" for number in range(10_000)], dtype="S4").view(np.uint32)
_BARE = np.array([f"{number}" if number else "" for number in range(10_000)], dtype="S4").view(np.uint32)


def _page(parts: Sequence[_Texts | bytes], count: int) -> _Texts:
    """`count` lines, each with the texts of all parts one after the other; a part of bytes is in every line."""
    widths = [f"S{len(part)}" if isinstance(part, bytes) else part.dtype for part in parts]
    page = np.empty(count, dtype=[(str(number), width) for number, width in enumerate(widths)])
    for number, part in enumerate(parts):
        page[str(number)] = part
    return page


def _bare(page: _Texts) -> bytes:
    """The lines as bytes, without padding."""
    return page.tobytes().translate(None, b"\0")
