"""Maps as models for a running simulation, in folders from which the simulator reads meshes as long as it runs."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from rsegen.errors import OutputError, ParameterError, RsegenError
from rsegen.exporters.scene import Scene, compose
from rsegen.field.stepfield import StepField
from rsegen.io.dataset.map_reference import recipe_in
from rsegen.io.recipe_file import load
from rsegen.io.resources import refuse_too_large
from rsegen.io.targets import found, map_index, recipe_files
from rsegen.io.text_files import text_of
from rsegen.recipe.recipe import Recipe
from rsegen.simulation.simulators.live_world import LiveWorld, Pose
from rsegen.simulation.spawning.spawned_map import SpawnedMap
from rsegen.simulation.worlds import Target, write_world

_MOST_MIB = 512

_MODEL_FILE = "model.sdf"


@dataclass(frozen=True, kw_only=True)
class MapModel:
    """The recipe of one map alone, its folder, which need not exist yet, and its scene if a caller gave one."""

    recipe: Recipe
    folder: Path
    made_of: Scene | None = None

    @property
    def name(self) -> str:
        """The map's name."""
        return self.folder.name

    @property
    def field(self) -> StepField:
        """The map's blocks."""
        return self.scene.field

    @cached_property
    def scene(self) -> Scene:
        """The map's scene; TooLarge if it does not fit into memory."""
        if self.made_of:
            return self.made_of
        refuse_too_large(self.recipe)
        return compose(self.recipe, self.recipe.first_map)

    def check_spawnable(self) -> None:
        """Raise a ParameterError if this cannot be spawned as one model."""
        if self.recipe.mesh_type != "single":
            problem = f"{self.recipe.mesh_type} makes a map of many models; only single can be spawned"
            raise ParameterError("mesh_type", problem)

    def sdf(self, name: str) -> str:
        """Its model file under a name, with absolute paths of meshes; the map is written first if it does not exist."""
        if not self.folder.is_dir():
            write_world(self.scene, self.folder.parent)
        file = self.folder / _MODEL_FILE
        text = text_of(file, _MOST_MIB, "a model")
        renamed = text.replace(f'<model name="{self.name}">', f'<model name="{name}">', 1)
        return renamed.replace(f"model://{self.name}/", f"{self.folder.resolve()}/")


def map_model(recipe: Recipe, index: int, output: Path, scene: Scene | None = None) -> MapModel:
    """A map of a recipe in an output folder; OutputError if a different map of its name exists there."""
    one = MapModel(recipe=recipe.alone(index), folder=output / recipe.map_name(index), made_of=scene)
    if one.folder.exists() and _recipe_in(one.folder) != one.recipe:
        advice = "give that folder to spawn it as it is, or another output folder, or the recipe a seed"
        raise OutputError(f"{one.folder}: exists already and is a different map; {advice}")
    return one


def map_of(target: Target, which: int | str | None, output: Path) -> MapModel:
    """The map of a target, by index or name, by default the first; one of a recipe goes into the output folder."""
    if isinstance(target, Scene):
        return map_model(target.recipe, target.index, output, target)
    if isinstance(target, Recipe):
        return map_model(target, map_index(target, which), output)
    path = os.fspath(target)
    file, recipe, index = found(path, None if which is None else str(which), "map")
    if os.path.isdir(path):
        return MapModel(recipe=recipe.alone(index), folder=file.parent)
    return map_model(recipe, index, output)


def maps_in(folder: str) -> list[MapModel]:
    """Every map in a folder, or the map whose folder it is."""
    return [MapModel(recipe=recipe_in(file), folder=file.parent) for file in recipe_files(folder)]


def known_recipes(live: LiveWorld, poses: Mapping[str, Pose], homes: Iterable[Path]) -> dict[str, Recipe]:
    """The recipes of the maps in a simulation by their names, where known: they are in the folder of the mesh, or in a
    folder of the map's name in one of `homes`.
    """
    meshes, homes = live.mesh_files(), list(homes)
    found = {}
    for name in poses:
        mesh = Path(meshes.get(name, ""))
        folders = [mesh.parents[1]] if mesh.is_absolute() and len(mesh.parts) > 3 else []
        folders += [home / name for home in homes if _is_map_name(name)]
        if recipe := next(filter(None, map(_recipe_in, folders)), None):
            found[name] = recipe
    return found


def known_maps(live: LiveWorld, poses: Mapping[str, Pose], homes: Iterable[Path]) -> list[SpawnedMap]:
    """Of the models in a simulation, the maps whose recipe is known."""
    found = known_recipes(live, poses, homes)
    return [
        SpawnedMap(name=name, field=compose(recipe, recipe.first_map).field, at=poses[name])
        for name, recipe in found.items()
    ]


def unknown_maps(poses: Mapping[str, Pose], known: Iterable[SpawnedMap]) -> list[str]:
    """The names of the models in a simulation that are called like maps, and are none of these."""
    names = {each.name for each in known}
    return [name for name in poses if _is_map_name(name) and name not in names]


def _is_map_name(name: str) -> bool:
    return re.fullmatch(r"[\w-]+_\d{4,}", name) is not None


def _recipe_in(folder: Path) -> Recipe | None:
    try:
        return load(folder / "recipe.json")
    except RsegenError:
        return None
