"""Parts of a map that several formats need: boxes of a colour, meshes split by material or texture, linear colours.

columns        boxes on the ground, each of one material, for both visual and collision geometry: mjcf, learning
coloured_objs  the surface in a file per material: mjcf, urdf
textured_...   the surface in parts of one material and one texture: mjcf, glb, usd
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple

import numpy as np

from rsegen.exporters.colours import Colour, linear, rounded
from rsegen.exporters.formats.solid import Solid
from rsegen.exporters.gazebo.obj import PARTS, obj
from rsegen.exporters.scene import Scene
from rsegen.field.stepfield import Mask, StepField
from rsegen.geometry import Mesh, surface, texture_coordinates
from rsegen.geometry.mesh import label_grid
from rsegen.geometry.rectangles import merge


class Column(NamedTuple):
    """A box on the ground: its centre and its size along x, y and z, metres, and its material."""

    centre: tuple[float, float, float]
    size: tuple[float, float, float]
    material: int


def columns(field: StepField) -> Iterator[Column]:
    """Yield few boxes that together fill the blocks and frames of a field and do not overlap."""
    grid = label_grid(field)
    rectangles = merge(grid.cells)
    rank, material = np.divmod(rectangles.label, grid.materials)
    x, y, z = grid.lattice.lines
    low = np.stack([x[rectangles.u0], y[rectangles.v0], np.zeros(len(rank))], axis=1)
    high = np.stack([x[rectangles.u1], y[rectangles.v1], z[rank]], axis=1)
    rows = zip(((low + high) / 2).tolist(), (high - low).tolist(), material.tolist(), strict=True)
    return (Column(tuple(centre), tuple(size), kind) for centre, size, kind in rows)


def coloured_objs(scene: Scene) -> Mapping[int, Iterable[bytes]]:
    """Return an OBJ file per material of the map; the colours are in the map's MTL file in the same folder."""
    return {material: obj([part], f"{scene.name}.mtl") for material, part in coloured(surface(scene.field))}


def textured_objs(scene: Scene) -> Iterator[tuple[int, str, Iterable[bytes]]]:
    """Yield an OBJ file with texture coordinates per material of the map and per texture, `top` or `side`."""
    for material, mesh in coloured(surface(scene.field)):
        sides = texture_coordinates(mesh, scene.field).sides
        for part, chosen in zip(PARTS, (~sides, sides), strict=True):
            if chosen.any():
                yield material, part, obj([mesh.part(chosen)], f"{scene.name}.mtl", scene.field)


def coloured(mesh: Mesh) -> Iterator[tuple[int, Mesh]]:
    """Yield each material with the mesh of its faces and the vertices that they use."""
    for material in np.unique(mesh.materials).tolist():
        yield material, mesh.part(mesh.materials == material)


def textured_groups(mesh: Solid) -> Iterator[tuple[int, str, Mask]]:
    """Yield each material with each texture that it has, and its triangles as a mask."""
    for material in np.unique(mesh.materials).tolist():
        for part, sides in zip(PARTS, (~mesh.sides, mesh.sides), strict=True):
            chosen = (mesh.materials == material) & sides
            if chosen.any():
                yield material, part, chosen


def srgb_to_linear(colour: Colour) -> Colour:
    """Return the linear colour of an sRGB colour as files have it."""
    return rounded(linear(colour), 6)
