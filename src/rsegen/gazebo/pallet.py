"""Mesh type `pallet`: every chunk with its adjacent frame is one model, as the pallets that a lab moves."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rsegen.field.stepfield import Chunk
from rsegen.gazebo import sdf, shapes
from rsegen.scene.scene import Scene


def files(scene: Scene) -> dict[str, Iterable[bytes]]:
    """Return the world of pallets and a mesh for each; pallets without a block above the ground are left out."""
    contents: dict[str, Iterable[bytes]] = {f"{scene.name}.world": sdf.utf8(sdf.world(scene, _models(scene)))}
    for name, pallet in _pallets(scene):
        contents |= shapes.mesh_files(scene, pallet.field, f"{scene.name}_{name}")
    return contents


def model_count(scene: Scene) -> int:
    """Return the number of pallets with a block above the ground."""
    return sum(1 for _ in _pallets(scene))


def collision_count(scene: Scene) -> int:
    """Return the number of collision shapes of all pallets."""
    return sum(shapes.collision_count(scene, pallet.field) for _, pallet in _pallets(scene))


def _models(scene: Scene) -> Iterator[str]:
    for name, pallet in _pallets(scene):
        own = shapes.shapes(scene, pallet.field, f"{scene.name}_{name}")
        yield from sdf.model(name, *own, sdf.numbers((*pallet.centre, 0)))


def _pallets(scene: Scene) -> Iterator[tuple[str, Chunk]]:
    chunks = scene.field.chunks(scene.recipe.chunk_size)
    return (("pallet_{}_{}".format(*chunk.index), chunk) for chunk in chunks if chunk.field.is_raised())
