"""The surface of a map split by colour, for programs that use one colour per mesh file."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

import numpy as np

from rsegen.exporters.gazebo.obj import obj
from rsegen.exporters.scene import Scene
from rsegen.geometry import Mesh, surface


def coloured_objs(scene: Scene) -> Mapping[int, Iterable[bytes]]:
    """An OBJ file per material of the map; the colours are in the map's MTL file in the same folder."""
    return {material: obj([part], f"{scene.name}.mtl") for material, part in coloured(surface(scene.field))}


def coloured(mesh: Mesh) -> Iterator[tuple[int, Mesh]]:
    """Each material with the mesh of its faces and the vertices that they use."""
    for material in np.unique(mesh.materials).tolist():
        yield material, mesh.part(mesh.materials == material)
