"""The surface of a map split by material, for programs that use one material per mesh file."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

import numpy as np

from rsegen.exporters.gazebo.obj import PARTS, obj
from rsegen.exporters.scene import Scene
from rsegen.geometry import Mesh, surface, texture_coordinates


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
