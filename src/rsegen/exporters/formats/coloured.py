"""The surface of a map cut by colour: for programs that give a mesh file one colour."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

import numpy as np

from rsegen.exporters.gazebo.obj import obj
from rsegen.exporters.scene import Scene
from rsegen.geometry import Mesh, surface


def coloured_objs(scene: Scene) -> Mapping[int, Iterable[bytes]]:
    """An OBJ file for each material that is there; the colours are in the map's MTL file beside it."""
    return {material: obj([part], f"{scene.name}.mtl") for material, part in coloured(surface(scene.field))}


def coloured(mesh: Mesh) -> Iterator[tuple[int, Mesh]]:
    """Of each material the faces that have it, with the vertices that these use."""
    for material in np.unique(mesh.materials).tolist():
        yield material, mesh.part(mesh.materials == material)
