"""The surface of a map cut by colour: for programs that give a mesh file one colour."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

import numpy as np

from rsegen.export.obj import obj
from rsegen.geometry import Mesh, surface
from rsegen.scene import Scene


def coloured_objs(scene: Scene) -> Mapping[int, Iterable[bytes]]:
    """An OBJ file for each material that is there; the colours are in the map's MTL file beside it."""
    return {material: obj([part], f"{scene.name}.mtl") for material, part in coloured(surface(scene.field))}


def coloured(mesh: Mesh) -> Iterator[tuple[int, Mesh]]:
    """Of each material the faces that have it, with the vertices that these use."""
    for material in np.unique(mesh.materials).tolist():
        of_it = mesh.materials == material
        used, corners = np.unique(mesh.faces[of_it], return_inverse=True)
        faces = corners.reshape(-1, mesh.faces.shape[1]).astype(np.int32)
        yield (
            material,
            Mesh(
                lines=mesh.lines,
                places=mesh.places[used],
                faces=faces,
                normals=mesh.normals[of_it],
                materials=mesh.materials[of_it],
            ),
        )
