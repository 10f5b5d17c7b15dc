"""Mesh type `pallet`: every chunk, with the frame beside it, is one model: what a lab moves about."""

from __future__ import annotations

from collections.abc import Iterable

from rsegen.export import sdf
from rsegen.export.obj import mtl, obj
from rsegen.geometry import surface
from rsegen.scene import Scene


def files(scene: Scene) -> dict[str, Iterable[bytes]]:
    """A world of pallets, and a mesh for each; pallets without a block above the ground are left out."""
    found: dict[str, Iterable[bytes]] = {f"meshes/{scene.name}.mtl": mtl(scene)}
    models = []
    for pallet in scene.field.pallets(scene.recipe.chunk_size):
        name = "pallet_{}_{}".format(*pallet.chunk)
        mesh = surface(pallet.field)
        if len(mesh.faces):
            uri = f"meshes/{scene.name}_{name}.obj"
            found[uri] = obj(mesh, f"{scene.name}.mtl")
            models.append(sdf.mesh_model(name, uri, scene.friction, pallet.centre))
    return found | {f"{scene.name}.world": sdf.encoded(sdf.world(scene, models))}
