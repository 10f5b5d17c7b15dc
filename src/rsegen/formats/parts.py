"""Parts of a map that several formats need: faces of one material and texture, OBJ files of them, linear colours.

groups    the faces of a mesh of one material and texture: ply, glb, usd
objs      the surface in a file per material and texture: mjcf, urdf
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from rsegen.field.stepfield import Ints, Mask
from rsegen.gazebo.obj import PARTS, obj
from rsegen.geometry import surface, texture_coordinates
from rsegen.scene.colours import Colour, linear, rounded_colour
from rsegen.scene.scene import Scene


def groups(materials: Ints, sides: Mask | None = None) -> Iterator[tuple[int, str, Mask]]:
    """Yield each material of some faces with each texture that it has, `top` or `side`, and the mask of its faces.

    sides: which faces have the texture of sides; without it none has a texture, and the name of the texture is empty
    """
    for material in np.unique(materials).tolist():
        faces = materials == material
        for part, chosen in (
            [("", faces)] if sides is None else zip(PARTS, (faces & ~sides, faces & sides), strict=True)
        ):
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
