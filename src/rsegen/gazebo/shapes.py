"""The visual and collision geometry of a field: its mesh files, and the shapes of a model that uses them.

A collision shape has one friction coefficient. So if a mesh has several, its collision geometry is split: the same
faces, in one file per coefficient.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import count

import numpy as np

from rsegen.field.stepfield import CellWindow, StepField
from rsegen.gazebo import sdf
from rsegen.gazebo.obj import mtl, obj, texture_files
from rsegen.geometry import Boxes, Mesh, box_per_block, boxes, meshes, split_window
from rsegen.params.numbers import decimal
from rsegen.scene.scene import Scene


def mesh_files(scene: Scene, field: StepField, stem: str) -> dict[str, Iterable[bytes]]:
    """Return the mesh files of a field by path in the map's folder, and the MTL file; generated while they are read."""
    textured = field if scene.recipe.is_textured else None
    contents: dict[str, Iterable[bytes]] = {
        f"meshes/{name}.obj": obj(meshes(field, scene.recipe.mesh, part), f"{scene.name}.mtl", textured)
        for name, part in _parts(scene, field, stem)
    }
    contents |= {path: content for path, _, content in _collision_meshes(scene, field, stem) if content}
    return contents | (material_files(scene) if contents else {})


def material_files(scene: Scene) -> dict[str, Iterable[bytes]]:
    """Return the MTL file and the images of its textures by their path in the map's folder."""
    contents = {f"{scene.name}.mtl": mtl(scene, textured=scene.recipe.is_textured)} | texture_files(scene)
    return {f"meshes/{name}": content for name, content in contents.items()}


def shapes(scene: Scene, field: StepField, stem: str, root: str = "") -> tuple[list[sdf.Shape], Iterator[sdf.Shape]]:
    """Return the visual and the collision shapes of a field; the URIs of their meshes start with `root`."""
    names = [f"{root}meshes/{name}.obj" for name, _ in _parts(scene, field, stem)]
    visuals = [sdf.mesh_geometry(shape, uri) for shape, uri in zip(_called("visual", len(names)), names, strict=True)]
    return visuals, _collisions(scene, field, stem, root)


def _collisions(scene: Scene, field: StepField, stem: str, root: str) -> Iterator[sdf.Shape]:
    """Yield the visual meshes, whole or split by friction, or boxes, as the recipe says."""
    if scene.recipe.collision == "mesh":
        cut = list(_collision_meshes(scene, field, stem))
        for shape, (path, friction, _) in zip(_called("collision", len(cut)), cut, strict=True):
            yield sdf.mesh_geometry(shape, root + path)._replace(friction=friction)
        return
    numbers = count()
    for friction, part in _boxes(scene, field):
        for size, centre in zip(part.sizes.tolist(), part.centres.tolist(), strict=True):
            yield sdf.box_geometry(f"collision_{next(numbers)}", size, centre)._replace(friction=friction)


def collision_count(scene: Scene, field: StepField) -> int:
    """Return the number of collision shapes of a field."""
    if scene.recipe.collision == "mesh":
        return sum(1 for _ in _collision_meshes(scene, field, ""))
    return sum(len(part) for _, part in _boxes(scene, field))


def split_by_friction(scene: Scene, field: StepField) -> Iterator[tuple[float, StepField]]:
    """Yield every friction coefficient in a field, with the part of the field that has it."""
    for friction, materials in scene.by_friction(field):
        yield friction, field if materials is None else field.only(materials)


def _collision_meshes(scene: Scene, field: StepField, stem: str) -> Iterator[tuple[str, float, Iterable[bytes] | None]]:
    """Yield path, friction coefficient and content of each collision mesh, if the recipe has any.

    The content is None if the visual mesh is the collision mesh too, as all of it has one coefficient.
    """
    for name, part in _parts(scene, field, stem) if scene.recipe.collision == "mesh" else ():
        for friction, materials in scene.by_friction(field, part):
            if materials is None:
                yield f"meshes/{name}.obj", friction, None
            else:
                faces = _of(materials, meshes(field, scene.recipe.mesh, part))
                path = f"meshes/touched/{name}_friction_{decimal(friction)}.obj"
                yield path, friction, obj(faces, f"../{scene.name}.mtl")


def _of(materials: Sequence[int], whole: Iterable[Mesh]) -> Iterator[Mesh]:
    """Yield the faces of some materials."""
    for mesh in whole:
        yield mesh.part(np.isin(mesh.materials, materials))


def _boxes(scene: Scene, field: StepField) -> Iterator[tuple[float, Boxes]]:
    """Return merged boxes, or one per block, of each friction coefficient."""
    cut = boxes if scene.recipe.collision == "boxes" else box_per_block
    return ((friction, cut(part)) for friction, part in split_by_friction(scene, field))


def _parts(scene: Scene, field: StepField, stem: str) -> Iterator[tuple[str, CellWindow]]:
    """Yield the name of every mesh and its window of the field: the whole field, or each tile that is not flat."""
    tile = scene.recipe.tile
    for part in split_window(field.whole, tile or max(field.shape)):
        if field.is_raised(part):
            suffix = f"_{part[0].start // tile}_{part[1].start // tile}" if tile else ""
            yield f"{stem}{suffix}", part


def _called(word: str, shapes: int) -> list[str]:
    """Return the names of the shapes of one link."""
    return [word] if shapes == 1 else [f"{word}_{index}" for index in range(shapes)]
