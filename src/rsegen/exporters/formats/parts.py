"""A map as boxes on the ground of one colour each, for both visual and collision geometry.

The surface of a map split by material, for programs that use one material per mesh file.

The parts of a surface with one material and one texture each, for glb and usd.

Linear colours, which glTF and USD use.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple

import numpy as np

from rsegen.exporters.formats.solid import Solid
from rsegen.exporters.gazebo.obj import PARTS, obj
from rsegen.exporters.scene import Colour, Scene
from rsegen.field.stepfield import Array, Ints, Mask, StepField
from rsegen.geometry import Mesh, surface, texture_coordinates
from rsegen.geometry.label_grid import label_grid
from rsegen.geometry.rectangles import merge


class Column(NamedTuple):
    """A box on the ground: its centre and its size along x, y and z, metres, and its material."""

    centre: tuple[float, float, float]
    size: tuple[float, float, float]
    material: int


def columns(field: StepField) -> Iterator[Column]:
    """Few boxes that together fill the blocks and frames of a field and do not overlap."""
    grid = label_grid(field)
    found = merge(grid.cells)
    rank, material = np.divmod(found.label, grid.materials)
    x, y, z = grid.lattice.lines
    low = np.stack([x[found.u0], y[found.v0], np.zeros(len(rank))], axis=1)
    high = np.stack([x[found.u1], y[found.v1], z[rank]], axis=1)
    rows = zip(((low + high) / 2).tolist(), (high - low).tolist(), material.tolist(), strict=True)
    return (Column(tuple(centre), tuple(size), kind) for centre, size, kind in rows)


def coloured_objs(scene: Scene) -> Mapping[int, Iterable[bytes]]:
    """An OBJ file per material of the map; the colours are in the map's MTL file in the same folder."""
    return {material: obj([part], f"{scene.name}.mtl") for material, part in coloured(surface(scene.field))}


def textured_objs(scene: Scene) -> Iterator[tuple[int, str, Iterable[bytes]]]:
    """An OBJ file with texture coordinates per material of the map and per texture, `top` or `side`."""
    for material, mesh in coloured(surface(scene.field)):
        sides = texture_coordinates(mesh, scene.field).sides
        for part, chosen in zip(PARTS, (~sides, sides), strict=True):
            if chosen.any():
                yield material, part, obj([mesh.part(chosen)], f"{scene.name}.mtl", scene.field)


def coloured(mesh: Mesh) -> Iterator[tuple[int, Mesh]]:
    """Each material with the mesh of its faces and the vertices that they use."""
    for material in np.unique(mesh.materials).tolist():
        yield material, mesh.part(mesh.materials == material)


class TexturedPart(NamedTuple):
    """The triangles of a material with one texture, `top` or `side`: vertices (n, 3) in metres, coordinates (n, 2)."""

    material: int
    part: str
    vertices: Array
    coordinates: Array
    triangles: Ints


def textured_groups(found: Solid) -> Iterator[tuple[int, str, Mask]]:
    """Each material with each texture that it has, and its triangles as a mask."""
    for material in np.unique(found.materials).tolist():
        for part, sides in zip(PARTS, (~found.sides, found.sides), strict=True):
            chosen = (found.materials == material) & sides
            if chosen.any():
                yield material, part, chosen


def textured_parts(found: Solid) -> Iterator[TexturedPart]:
    """The triangles of each material and texture; a vertex is there once per pair of texture coordinates."""
    for material, part, chosen in textured_groups(found):
        places = found.vertices[found.triangles[chosen]]
        corners = np.concatenate([places, found.coordinates[chosen]], axis=2).reshape(-1, 5)
        known, numbers = np.unique(corners, axis=0, return_inverse=True)
        yield TexturedPart(material, part, known[:, :3], known[:, 3:], numbers.reshape(-1, 3))


def srgb_to_linear(colour: Colour) -> Colour:
    """The linear colour of an sRGB colour (IEC 61966-2-1)."""
    red, green, blue = (
        round(part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4, 6) for part in colour
    )
    return red, green, blue
