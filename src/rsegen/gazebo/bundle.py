"""The bundle of one map: its files as bytes, before they are written. Its mesh type says which models it has.

`single`: the map is one model, in a package that any world can include. `pallet`: every chunk with its adjacent frame
is one, as the pallets that a lab moves. `multi`: every cell is one (`multi.py`).
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from itertools import chain
from pathlib import PurePosixPath
from typing import NamedTuple

from rsegen.field.stepfield import StepField
from rsegen.gazebo import multi, sdf, shapes
from rsegen.recipe.codec import map_json
from rsegen.scene.scene import Scene, csv

Bundle = Mapping[PurePosixPath, Iterable[bytes]]
"""The content of each file in chunks of bytes by its path in the map's folder; to be read once."""


def export(scene: Scene) -> Bundle:
    """Return all files of a map: world and models by its mesh type, levels, its recipe, the constraint report."""
    files = MESH_TYPES[scene.recipe.mesh_type].files(scene)
    files["levels.csv"] = csv(scene.field)
    if scene.recipe.is_constrained:
        from rsegen.gazebo.constraint_report import constraint_report

        files["constraints.json"] = [(json.dumps(constraint_report(scene), indent=2) + "\n").encode()]
    files["recipe.json"] = [map_json(scene.recipe, scene.index)]
    return {PurePosixPath(path): content for path, content in files.items()}


class _Part(NamedTuple):
    """A part of a map that is one model: its name, the start of its meshes' names, its field, and x, y and z."""

    name: str
    stem: str
    field: StepField
    place: str = "0 0 0"


def _whole(scene: Scene) -> Sequence[_Part]:
    """Return the map as one part."""
    return [_Part(scene.name, scene.name, scene.field)]


def _pallets(scene: Scene) -> Sequence[_Part]:
    """Return the chunks that have a block above the ground."""
    parts = []
    for chunk in scene.field.chunks(scene.recipe.chunk_size):
        if chunk.field.is_raised():
            name = "pallet_{}_{}".format(*chunk.index)
            parts.append(_Part(name, f"{scene.name}_{name}", chunk.field, sdf.numbers((*chunk.centre, 0))))
    return parts


def _package(scene: Scene) -> dict[str, Iterable[bytes]]:
    """Return the model package of the whole map, and a world that has this model."""
    model = _models(scene, _whole(scene), f"model://{scene.name}/")
    return {
        "model.config": [_CONFIG.format(name=scene.name, version=sdf.VERSION).encode()],
        "model.sdf": sdf.utf8(chain([sdf.HEADER], model, [sdf.FOOTER])),
        **_world(_whole, scene),
    }


def _world(parts_of: Callable[[Scene], Sequence[_Part]], scene: Scene) -> dict[str, Iterable[bytes]]:
    """Return the world of the parts of a map, and their meshes."""
    parts = parts_of(scene)
    contents: dict[str, Iterable[bytes]] = {f"{scene.name}.world": sdf.utf8(sdf.world(scene, _models(scene, parts)))}
    for part in parts:
        contents |= shapes.mesh_files(scene, part.field, part.stem)
    return contents


def _models(scene: Scene, parts: Iterable[_Part], root: str = "") -> Iterator[str]:
    """Yield the text of a model for each part; the URIs of their meshes start with `root`."""
    is_body = scene.recipe.simulator == "classic"
    for part in parts:
        own = shapes.shapes(scene, part.field, part.stem, root)
        yield from sdf.model(part.name, *own, part.place, is_body=is_body)


def _counts(parts_of: Callable[[Scene], Sequence[_Part]], scene: Scene) -> tuple[int, int]:
    """Return the numbers of parts, and of their collision shapes: meshes (tiles, or parts of one friction) or boxes."""
    parts = parts_of(scene)
    return len(parts), sum(shapes.collision_count(scene, part.field) for part in parts)


class MeshType(NamedTuple):
    """A way to make models of a map.

    files: from a scene to the world file and all other files that it needs, by path in the map's folder
    counts: from a scene to the numbers of models and of collision shapes in the world
    """

    files: Callable[[Scene], dict[str, Iterable[bytes]]]
    counts: Callable[[Scene], tuple[int, int]]


MESH_TYPES: Mapping[str, MeshType] = {
    "single": MeshType(_package, partial(_counts, _whole)),
    "multi": MeshType(multi.files, multi.counts),
    "pallet": MeshType(partial(_world, _pallets), partial(_counts, _pallets)),
}


_CONFIG = """\
<?xml version="1.0"?>
<model>
  <name>{name}</name>
  <version>1.0</version>
  <sdf version="{version}">model.sdf</sdf>
  <author>
    <name>rsegen</name>
  </author>
  <description>A Random Step Environment; recipe.json makes it again.</description>
</model>
"""
