"""Mesh type `pallet`: every chunk, with the frame beside it, is one model: what a lab moves about."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rsegen.exporters.gazebo import sdf, shapes
from rsegen.exporters.scene import Scene
from rsegen.field.stepfield import Pallet


def files(scene: Scene) -> dict[str, Iterable[bytes]]:
    """A world of pallets, and a mesh for each; pallets without a block above the ground are left out."""
    found: dict[str, Iterable[bytes]] = {f"{scene.name}.world": sdf.encoded(sdf.world(scene, _models(scene)))}
    for pallet in _standing(scene):
        found |= shapes.mesh_files(scene, pallet.field, _stem(scene, pallet))
    return found


def models(scene: Scene) -> int:
    """Pallets with a block above the ground."""
    return sum(1 for _ in _standing(scene))


def collisions(scene: Scene) -> int:
    """Of all of them."""
    return sum(shapes.collisions(scene, pallet.field) for pallet in _standing(scene))


def _models(scene: Scene) -> Iterator[str]:
    for pallet in _standing(scene):
        stem = _stem(scene, pallet)
        seen, touched = (shape(scene, pallet.field, stem) for shape in (shapes.seen, shapes.touched))
        yield from sdf.model(_name(pallet), seen, touched, sdf.numbers((*pallet.centre, 0)))


def _standing(scene: Scene) -> Iterator[Pallet]:
    return (pallet for pallet in scene.field.pallets(scene.recipe.chunk_size) if pallet.field.stands())


def _name(pallet: Pallet) -> str:
    return "pallet_{}_{}".format(*pallet.chunk)


def _stem(scene: Scene, pallet: Pallet) -> str:
    return f"{scene.name}_{_name(pallet)}"
