"""Mesh type `pallet`: every chunk, with the frame beside it, is one model: what a lab moves about."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rsegen.export import sdf
from rsegen.export.obj import mtl, obj
from rsegen.geometry import surface
from rsegen.scene import Scene
from rsegen.stepfield import Pallet


def files(scene: Scene) -> dict[str, Iterable[bytes]]:
    """A world of pallets, and a mesh for each; pallets without a block above the ground are left out."""
    found: dict[str, Iterable[bytes]] = {f"meshes/{scene.name}.mtl": mtl(scene)}
    parts = []
    for pallet in _standing(scene):
        name = "pallet_{}_{}".format(*pallet.chunk)
        uri = f"meshes/{scene.name}_{name}.obj"
        found[uri] = obj(surface(pallet.field), f"{scene.name}.mtl")
        parts.append(sdf.mesh_model(name, uri, scene.friction, pallet.centre))
    return found | {f"{scene.name}.world": sdf.encoded(sdf.world(scene, parts))}


def models(scene: Scene) -> int:
    """Pallets with a block above the ground."""
    return sum(1 for _ in _standing(scene))


def faces(scene: Scene) -> int:
    """Rectangles of all their surfaces."""
    return sum(len(surface(pallet.field).faces) for pallet in _standing(scene))


def _standing(scene: Scene) -> Iterator[Pallet]:
    return (pallet for pallet in scene.field.pallets(scene.recipe.chunk_size) if pallet.field.heights.any())
