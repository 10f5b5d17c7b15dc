"""Wavefront OBJ and MTL: the mesh format that both Gazebos load fastest.

Absolute indices, one normal for each face (a file without normals crashes Gazebo Sim), one group for each material.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from rsegen.export.numbers import decimal
from rsegen.geometry import NORMALS, Mesh
from rsegen.scene import Scene


def obj(mesh: Mesh, mtl_name: str) -> Iterator[bytes]:
    """The OBJ file of a mesh, whose colours are in the file `mtl_name` beside it."""
    yield f"# metres, z up; made by rsegen\nmtllib {mtl_name}\n".encode()
    yield _vertices(mesh)
    yield "".join(f"vn {x} {y} {z}\n" for x, y, z in NORMALS).encode()
    for material in np.unique(mesh.materials):
        name = material_name(int(material))
        yield f"g {name}\nusemtl {name}\n".encode()
        yield _faces(mesh, mesh.materials == material)


def mtl(scene: Scene) -> Iterator[bytes]:
    """The MTL file of every colour that a map of the scene's recipe can have."""
    for material in range(scene.recipe.top_level + 1):
        red, green, blue = map(decimal, scene.colour(material))
        colour = f"{red} {green} {blue}"
        yield f"newmtl {material_name(material)}\nKa {colour}\nKd {colour}\nKs 0 0 0\nd 1\nillum 1\n".encode()


def material_name(material: int) -> str:
    """What OBJ and MTL call a material: 0 is the frame, any other the level."""
    return f"level_{material}" if material else "frame"


def _vertices(mesh: Mesh) -> bytes:
    """Coordinates come from few distinct numbers: each is formatted once."""
    columns = []
    for column in mesh.vertices.T:
        values, numbers = np.unique(column, return_inverse=True)
        texts = [decimal(float(value)) for value in values]
        columns.append([texts[number] for number in numbers.tolist()])
    return "".join(f"v {x} {y} {z}\n" for x, y, z in zip(*columns, strict=True)).encode()


def _faces(mesh: Mesh, which: np.ndarray) -> bytes:
    rows = np.column_stack([mesh.faces[which] + 1, mesh.normals[which] + 1]).tolist()
    return "".join(f"f {a}//{n} {b}//{n} {c}//{n} {d}//{n}\n" for a, b, c, d, n in rows).encode()
