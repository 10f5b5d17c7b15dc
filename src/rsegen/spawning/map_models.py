"""Maps as models of a simulation: the one that is to be spawned, and the recipes of the maps in it."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from xml.sax.saxutils import escape

from rsegen.errors import OutputError, ParameterError, RsegenError
from rsegen.field.stepfield import StepField
from rsegen.input_files import text_of
from rsegen.recipe.recipe import Recipe
from rsegen.recipe.recipe_file import load
from rsegen.scene.scene import Scene
from rsegen.simulators.live_world import LiveWorld
from rsegen.simulators.poses import Pose
from rsegen.spawning.placement import SpawnedMap
from rsegen.writing.target_worlds import Target, chosen, scene_of, write_world

_MAX_MODEL_MIB = 512
"""The largest model that is read, MiB, and sent to the simulator as one message."""


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
        return self.made_of or scene_of(self.recipe)

    def check_spawnable(self) -> None:
        """Raise a ParameterError if this cannot be spawned as one model."""
        if self.recipe.mesh_type != "single":
            problem = f"{self.recipe.mesh_type} makes a map of many models; only single can be spawned"
            raise ParameterError("mesh_type", problem)

    def sdf(self, name: str) -> str:
        """Return its model file under a name, with absolute paths of meshes; the map is written first if need be."""
        if not self.folder.is_dir():
            write_world(self.scene, self.folder.parent)
        text = text_of(self.folder / "model.sdf", _MAX_MODEL_MIB, "a model")
        renamed = text.replace(f'<model name="{self.name}">', f'<model name="{name}">', 1)
        return renamed.replace(f"model://{self.name}/", escape(f"{self.folder.resolve()}/"))


def map_model(recipe: Recipe, output: Path, scene: Scene | None = None) -> MapModel:
    """Return the map of a recipe in an output folder; OutputError if a different map of its name exists there."""
    model = MapModel(recipe=recipe, folder=output / recipe.map_name(recipe.first_map), made_of=scene)
    if model.folder.exists() and _recipe_in(model.folder) != model.recipe:
        advice = "use that folder to spawn it as it is, or another output folder, or the recipe a seed"
        raise OutputError(f"{model.folder}: exists already and is a different map; {advice}")
    return model


def map_of(target: Target, which: int | str | None, output: Path) -> MapModel:
    """Return the map of a target, by index or name, by default the first; a recipe's goes into the output folder."""
    recipe, folder, scene = chosen(target, which)
    return MapModel(recipe=recipe, folder=folder) if folder else map_model(recipe, output, scene)


def known_recipes(live: LiveWorld, poses: Mapping[str, Pose], homes: Iterable[Path]) -> dict[str, Recipe]:
    """Return the known recipes of the maps in a simulation, by their names.

    A recipe is known if it is in the folder of the mesh, or in a folder of the map's name in one of `homes`.
    """
    meshes, homes = live.mesh_files(), list(homes)
    recipes = {}
    for name in poses:
        mesh = Path(meshes.get(name, ""))
        folders = [mesh.parents[1]] if mesh.is_absolute() and len(mesh.parts) > 3 else []
        folders += [home / name for home in homes if _is_map_name(name)]
        if recipe := next(filter(None, map(_recipe_in, folders)), None):
            recipes[name] = recipe
    return recipes


def unknown_map_notes(poses: Mapping[str, Pose], known: Iterable[SpawnedMap]) -> Iterator[str]:
    """Yield a warning for each model that is called like a map and is none of these: its heights are unknown."""
    names = {spawned.name for spawned in known}
    for name in poses:
        if _is_map_name(name) and name not in names:
            advice = "the robot may be inside them; set output='DIR', the folder that it is in, or at=[X, Y, Z]"
            yield f"the heights of the blocks of {name} are unknown, as its recipe.json was not found; {advice}"


def _is_map_name(name: str) -> bool:
    return re.fullmatch(r"[\w-]+_\d{4,}", name) is not None


def _recipe_in(folder: Path) -> Recipe | None:
    try:
        return load(folder / "recipe.json")
    except RsegenError:
        return None
