"""What is seen and touched of a field: its mesh files, and the shapes of a model that uses them.

A shape that is touched has one coefficient of friction. So where a mesh has several, what is touched is cut by them:
the same faces, in a file for each coefficient.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import count
from typing import NamedTuple

import numpy as np

from rsegen.exporters.gazebo import sdf
from rsegen.exporters.gazebo.obj import mtl, obj
from rsegen.exporters.numbers import decimal
from rsegen.exporters.scene import Scene
from rsegen.field.stepfield import StepField, Window
from rsegen.geometry import Boxes, Mesh, box_per_block, boxes, meshes, split_window


def mesh_files(scene: Scene, field: StepField, stem: str) -> dict[str, Iterable[bytes]]:
    """The meshes of a field by their path in the map's folder, and the colours; made as they are read."""
    found: dict[str, Iterable[bytes]] = {
        f"meshes/{name}.obj": obj(meshes(field, scene.recipe.mesh, part), f"{scene.name}.mtl")
        for name, part in _parts(scene, field, stem)
    }
    for each in _collision_meshes(scene, field, stem):
        if each.materials is not None:
            found[each.path] = obj(_of(each, scene, field), f"../{scene.name}.mtl")
    return found | ({f"meshes/{scene.name}.mtl": mtl(scene)} if found else {})


def visuals(scene: Scene, field: StepField, stem: str, root: str = "") -> Iterator[sdf.Shape]:
    """The meshes as shapes; their URIs start with `root`."""
    names = [name for name, _ in _parts(scene, field, stem)]
    for shape, name in zip(_called("visual", len(names)), names, strict=True):
        yield sdf.mesh(shape, f"{root}meshes/{name}.obj")


def collisions(scene: Scene, field: StepField, stem: str, root: str = "") -> Iterator[sdf.Shape]:
    """The same meshes, whole or cut by their friction, or boxes, as the recipe says."""
    if scene.recipe.collision == "mesh":
        found = list(_collision_meshes(scene, field, stem))
        for shape, each in zip(_called("collision", len(found)), found, strict=True):
            yield sdf.mesh(shape, root + each.path)._replace(friction=each.friction)
        return
    numbers = count()
    for friction, part in _boxes(scene, field):
        for size, centre in zip(part.sizes.tolist(), part.centres.tolist(), strict=True):
            yield sdf.box(f"collision_{next(numbers)}", size, centre)._replace(friction=friction)


def collision_count(scene: Scene, field: StepField) -> int:
    """How many shapes can be touched."""
    if scene.recipe.collision == "mesh":
        return sum(1 for _ in _collision_meshes(scene, field, ""))
    return sum(len(part) for _, part in _boxes(scene, field))


def split_by_friction(scene: Scene, field: StepField) -> Iterator[tuple[float, StepField]]:
    """Every coefficient of friction in a field, and the field with nothing but what has it."""
    for friction, materials in scene.by_friction(field):
        yield friction, field if materials is None else field.only(materials)


class _CollisionMesh(NamedTuple):
    """A mesh file that is touched: its path, what part of a field is in it, and of which materials (None: of all)."""

    path: str
    part: Window
    friction: float
    materials: Sequence[int] | None


def _collision_meshes(scene: Scene, field: StepField, stem: str) -> Iterator[_CollisionMesh]:
    """What is seen, or parts of it where it has several coefficients and is touched."""
    if scene.recipe.collision != "mesh":
        return
    for name, part in _parts(scene, field, stem):
        for friction, materials in scene.by_friction(field, part):
            cut = "" if materials is None else f"_friction_{decimal(friction)}"
            yield _CollisionMesh(f"meshes/{'touched/' if cut else ''}{name}{cut}.obj", part, friction, materials)


def _of(each: _CollisionMesh, scene: Scene, field: StepField) -> Iterator[Mesh]:
    """The faces that have its materials."""
    for mesh in meshes(field, scene.recipe.mesh, each.part):
        yield mesh.part(np.isin(mesh.materials, each.materials or ()))


def _boxes(scene: Scene, field: StepField) -> Iterator[tuple[float, Boxes]]:
    """Few boxes, or one a block, of each coefficient."""
    cut = boxes if scene.recipe.collision == "boxes" else box_per_block
    return ((friction, cut(part)) for friction, part in split_by_friction(scene, field))


def _parts(scene: Scene, field: StepField, stem: str) -> Iterator[tuple[str, Window]]:
    """The name of every mesh and what part of the field is in it: all of it, or a tile that has anything in it."""
    tile = scene.recipe.tile
    for part in split_window(field.whole, tile or max(field.shape)):
        if field.stands(part):
            number = f"_{part[0].start // tile}_{part[1].start // tile}" if tile else ""
            yield f"{stem}{number}", part


def _called(word: str, shapes: int) -> list[str]:
    """The names of so many shapes of one link."""
    return [word] if shapes == 1 else [f"{word}_{number}" for number in range(shapes)]
