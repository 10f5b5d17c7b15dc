"""Wavefront OBJ and MTL files, the mesh format that both Gazebos load fastest.

Absolute indices, one normal per face (a file without normals crashes Gazebo Sim), one group per material. There are few
distinct coordinates, and indices are consecutive, so each number is formatted once and gathered as bytes.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from rsegen.field.stepfield import Ints, StepField
from rsegen.geometry import NORMALS, TILES, Mesh, TextureCoordinates, texture_coordinates
from rsegen.params.numbers import decimal
from rsegen.params.watch import LARGE, report_share
from rsegen.scene.looks.looks import textures
from rsegen.scene.scene import Scene

_Texts = NDArray[np.void]
"""Texts of one width, padded with zero bytes, as items of that many bytes."""

STRIP = 2**15
"""Lines that are made at once: enough to be fast, few enough to stay in the CPU cache (some 2 MB)."""


def obj(meshes: Iterable[Mesh], mtl_name: str, textured: StepField | None = None) -> Iterator[bytes]:
    """Yield the OBJ file of meshes, one after the other, with the materials of the file `mtl_name` in the same folder.

    With the field `textured`, of which they are meshes, they have texture coordinates.
    """
    yield f"# metres, z up; made by rsegen\nmtllib {mtl_name}\n".encode()
    yield "".join(f"vn {x} {y} {z}\n" for x, y, z in NORMALS).encode()
    # OBJ counts vertices and texture coordinates from the beginning of the file, so over all meshes.
    vertices = coordinates = 0
    for mesh in meshes:
        texture = None if textured is None else texture_coordinates(mesh, textured)
        lines = [_texts([f" {decimal(value)}" for value in line.tolist()]) for line in mesh.lines]
        for strip in _strips(len(mesh.places), "vertices"):
            columns = [line[at] for line, at in zip(lines, mesh.places[strip].T, strict=True)]
            yield _bare(_page([b"v", *columns, b"\n"], len(columns[0])))
        values = texture.values if texture else np.zeros((0, 2))
        for strip in _strips(len(values), "textures"):
            pairs = (values[strip] / TILES).round(9).tolist()
            yield "".join(f"vt {decimal(u)} {decimal(v)}\n" for u, v in pairs).encode()
        yield from _faces(mesh, vertices + 1, texture, coordinates + 1)
        coordinates += len(values)
        vertices += len(mesh.places)


def face_count(piece: bytes) -> int:
    """Return the number of faces in a chunk of an OBJ file."""
    return piece.count(b"\nf ") + piece.startswith(b"f ")


def mtl(scene: Scene, *, textured: bool) -> Iterator[bytes]:
    """Yield the MTL file with every material that maps of the scene's recipe can have; textured: and its textures."""
    levels = range(scene.recipe.highest_level + 1)
    materials = [(material_name(level), scene.surface_colour(level), "") for level in levels]
    for level in levels if textured else ():
        for part in PARTS:
            image = f"map_Kd {texture_name(scene, part)}\n"
            materials.append((material_name(level, part), scene.tint(level), image))
    for name, colour, image in materials:
        rgb = " ".join(map(decimal, colour))
        yield f"newmtl {name}\nKa {rgb}\nKd {rgb}\nKs 0 0 0\nd 1\nillum 1\n{image}".encode()


PARTS = ("top", "side")
"""Parts of a block that have textures of their own; frames have the texture of sides all over."""


def texture_name(scene: Scene, part: str) -> str:
    """Return the name of the image of tops or of sides, which no other map in a world has."""
    return f"{scene.name}_{part}.png"


def texture_files(scene: Scene) -> dict[str, Iterable[bytes]]:
    """Return the images of the recipe's look by name; none if it has no textures."""
    if not scene.recipe.is_textured:
        return {}
    images = textures(scene.recipe.look, scene.recipe.seed or 0)
    return {texture_name(scene, part): [image] for part, image in zip(PARTS, images, strict=True)}


def material_name(material: int, part: str = "") -> str:
    """Return the name of a material in OBJ and MTL, with its texture `part` if it has one: `frame` for 0, `level_3`."""
    return (f"level_{material}" if material else "frame") + (part and f"_{part}")


def _faces(mesh: Mesh, first: int, texture: TextureCoordinates | None, first_coordinate: int) -> Iterator[bytes]:
    """Yield the faces, a group per material, with textures one of tops and then one of sides.

    first, first_coordinate: the numbers of the first vertex and of its first texture coordinates
    """
    numbers, order = _counted(first, len(mesh.places)), None
    groups: Ints = mesh.materials
    if texture:
        groups, order = 2 * groups.astype(int) + texture.sides, np.lexsort((texture.sides, mesh.materials))
        own = _texts([f"/{index}" for index in range(first_coordinate, first_coordinate + len(texture.values))])
    normals = _texts([f"{'/' if texture else '//'}{row + 1}" for row in range(len(NORMALS))])
    # Lines of bytes per strip of faces, cut where a group ends; the first line of a group is preceded by its name.
    before = -1
    for strip in _strips(len(mesh.faces), "faces"):
        rows = strip if order is None else order[strip]
        normal = normals[mesh.normals[rows]]
        corners: list[_Texts | bytes] = []
        for corner in range(mesh.faces.shape[1]):
            at = [own[texture.corners[rows, corner]]] if texture else []
            corners += [b" ", numbers[mesh.faces[rows, corner]], *at, normal]
        page, own_groups = _page([b"f", *corners, b"\n"], len(normal)), groups[rows]
        changes = np.flatnonzero(np.diff(own_groups)) + 1
        for low, high in pairwise([0, *changes.tolist(), len(own_groups)]):
            group = int(own_groups[low])
            if group != before:
                name = material_name(group // 2, PARTS[group % 2]) if texture else material_name(group)
                yield f"g {name}\nusemtl {name}\n".encode()
            yield _bare(page[low:high])
            before = group


def _strips(count: int, what: str) -> Iterator[slice]:
    """Yield the lines that are made at once; for many of them, report the progress."""
    for low in range(0, count, STRIP):
        yield slice(low, min(low + STRIP, count))
        if count > LARGE:
            report_share(f"{what} of an OBJ file", min(low + STRIP, count) / count)


def _texts(texts: Sequence[str]) -> _Texts:
    plain = np.array(texts, dtype="S")
    return plain.view(f"V{plain.itemsize}")


def _counted(first: int, count: int) -> _Texts:
    """Return the texts of the numbers from `first` on, put together from texts of four digits each."""
    numbers = np.arange(first, first + count)
    if first + count > 10**8:  # more than eight digits
        return _texts(numbers.astype("S").tolist())
    high, low = np.divmod(numbers.astype(np.int32), 10_000)
    halves = np.stack([_BARE[high], np.where(high > 0, _PADDED[low], _BARE[low])], axis=1)
    return halves.reshape(-1).view("V8")


# Texts of four digits, as 32-bit numbers: with leading zeros, and without any (which is padding for `_bare`).
_PADDED = np.array([f"{number:04d}" for number in range(10_000)], dtype="S4").view(np.uint32)
_BARE = np.array([f"{number}" if number else "" for number in range(10_000)], dtype="S4").view(np.uint32)


def _page(parts: Sequence[_Texts | bytes], count: int) -> _Texts:
    """Return `count` lines, each with the texts of all parts one after the other; a part of bytes is in every line."""
    widths = [f"S{len(part)}" if isinstance(part, bytes) else part.dtype for part in parts]
    page = np.empty(count, dtype=[(str(index), width) for index, width in enumerate(widths)])
    for index, part in enumerate(parts):
        page[str(index)] = part
    return page


def _bare(page: _Texts) -> bytes:
    """Return the lines as bytes, without padding."""
    return page.tobytes().translate(None, b"\0")
