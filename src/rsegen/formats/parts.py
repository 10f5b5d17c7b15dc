"""Parts of a map that several formats need: boxes of a colour, faces of one material and texture, linear colours.

columns   boxes on the ground, each of one material, for both visual and collision geometry: mjcf, learning
groups    the faces of a mesh of one material and texture: ply, glb, usd
objs      the surface in a file per material and texture: mjcf, urdf
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np

from rsegen.field.stepfield import Ints, Mask, StepField
from rsegen.gazebo.obj import PARTS, obj
from rsegen.geometry import surface, texture_coordinates
from rsegen.geometry.mesh import label_grid
from rsegen.geometry.rectangles import merge
from rsegen.scene.colours import Colour, linear, rounded_colour
from rsegen.scene.scene import Scene


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


def groups(materials: Ints, sides: Mask | None = None) -> Iterator[tuple[int, str, Mask]]:
    """Yield each material of some faces with each texture that it has, `top` or `side`, and the mask of its faces.

    sides: which faces have the texture of sides; without it none has a texture, and the name of the texture is empty
    """
    for material in np.unique(materials).tolist():
        own = materials == material
        for part, chosen in [("", own)] if sides is None else zip(PARTS, (own & ~sides, own & sides), strict=True):
            if chosen.any():
                yield material, part, chosen


def objs(scene: Scene, *, textured: bool = False) -> Iterator[tuple[int, str, Iterable[bytes]]]:
    """Yield an OBJ file of the surface per material, whose colour is in the map's MTL file in the same folder.

    textured: a file per texture too, with texture coordinates
    """
    mesh, field = surface(scene.field), scene.field if textured else None
    sides = texture_coordinates(mesh, field).sides if field else None
    for material, part, chosen in groups(mesh.materials, sides):
        yield material, part, obj([mesh.part(chosen)], f"{scene.name}.mtl", field)


def srgb_to_linear(colour: Colour) -> Colour:
    """Return the linear colour of an sRGB colour as files have it."""
    return rounded_colour(linear(colour), 6)
