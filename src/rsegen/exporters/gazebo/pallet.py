"""Mesh type `pallet`: every chunk with its adjacent frame is one model, as the pallets that a lab moves."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rsegen.exporters.gazebo import sdf, shapes
from rsegen.exporters.scene import Scene
from rsegen.field.stepfield import Chunk


def files(scene: Scene) -> dict[str, Iterable[bytes]]:
    """The world of pallets and a mesh for each; pallets without a block above the ground are left out."""
    contents: dict[str, Iterable[bytes]] = {f"{scene.name}.world": sdf.utf8(sdf.world(scene, _models(scene)))}
    for pallet in _pallets(scene):
        contents |= shapes.mesh_files(scene, pallet.field, _stem(scene, pallet))
    return contents


def model_count(scene: Scene) -> int:
    """The number of pallets with a block above the ground."""
    return sum(1 for _ in _pallets(scene))


def collision_count(scene: Scene) -> int:
    """The number of collision shapes of all pallets."""
    return sum(shapes.collision_count(scene, pallet.field) for pallet in _pallets(scene))


def _models(scene: Scene) -> Iterator[str]:
    for pallet in _pallets(scene):
        stem = _stem(scene, pallet)
        visuals, collisions = (shape(scene, pallet.field, stem) for shape in (shapes.visuals, shapes.collisions))
        yield from sdf.model(_name(pallet), visuals, collisions, sdf.numbers((*pallet.centre, 0)))


def _pallets(scene: Scene) -> Iterator[Chunk]:
    return (pallet for pallet in scene.field.chunks(scene.recipe.chunk_size) if pallet.field.stands())


def _name(chunk: Chunk) -> str:
    return "pallet_{}_{}".format(*chunk.index)


def _stem(scene: Scene, chunk: Chunk) -> str:
    return f"{scene.name}_{_name(chunk)}"
