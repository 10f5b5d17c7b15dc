"""Maps for a running simulation: models on disk, where the simulator reads their meshes as long as it runs."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from rsegen.errors import FileError, NoSimulator, OutputError, ParameterError, RsegenError
from rsegen.exporters.scene import compose
from rsegen.field.stepfield import StepField
from rsegen.io.recipe_file import load
from rsegen.io.resources import refuse_too_large
from rsegen.io.worlds import generate
from rsegen.recipe.recipe import Recipe
from rsegen.simulation.simulators import Simulator
from rsegen.simulation.simulators.live_world import Pose
from rsegen.simulation.spawning.spawned_map import SpawnedMap


@dataclass(frozen=True, kw_only=True, slots=True)
class MapModel:
    """The recipe of one map alone, and its folder; the folder need not be there yet."""

    recipe: Recipe
    folder: Path

    @property
    def name(self) -> str:
        """What it is called."""
        return self.folder.name

    @property
    def field(self) -> StepField:
        """Its blocks."""
        refuse_too_large(self.recipe)
        return compose(self.recipe, self.recipe.first_map).field

    def check_fits(self, simulator: Simulator) -> None:
        """An error where this cannot be one model of that simulator."""
        if not simulator.can_open(self.recipe.simulator):
            raise NoSimulator(f"{simulator.title} runs, and this map's recipe says simulator: {self.recipe.simulator}")
        if self.recipe.mesh_type != "single":
            problem = f"{self.recipe.mesh_type} makes a map of many models; only single can be put into a simulation"
            raise ParameterError("mesh_type", problem)

    def model(self, name: str) -> str:
        """Its model file under a name, with meshes by absolute paths; the map is made where it is not there yet."""
        if not self.folder.is_dir():
            generate(self.recipe, self.folder.parent)
        file = self.folder / "model.sdf"
        try:
            text = file.read_text("utf-8")
        except (OSError, UnicodeDecodeError) as error:
            raise FileError(f"{file}: {getattr(error, 'strerror', None) or error}") from None
        renamed = text.replace(f'<model name="{self.name}">', f'<model name="{name}">', 1)
        return renamed.replace(f"model://{self.name}/", f"{self.folder.resolve()}/")


def map_model(recipe: Recipe, index: int, output: Path) -> MapModel:
    """A map of a recipe in a folder; an OutputError where another of its name is there."""
    one = MapModel(recipe=recipe.alone(index), folder=output / recipe.map_name(index))
    if one.folder.exists() and _recipe_in(one.folder) != one.recipe:
        advice = "give that folder to put it in as it is, or another -o, or the recipe a seed"
        raise OutputError(f"{one.folder}: is there already and is another map; {advice}")
    return one


def known(poses: Mapping[str, Pose], homes: Iterable[Path]) -> list[SpawnedMap]:
    """Of the models of a simulation, the maps that lie in one of these folders under their names."""
    named = ((name, home / name) for name in poses if re.fullmatch(r"[\w-]+_\d{4,}", name) for home in homes)
    there = {name: recipe for name, folder in named if (recipe := _recipe_in(folder))}
    return [
        SpawnedMap(name=name, field=compose(recipe, recipe.first_map).field, at=poses[name])
        for name, recipe in there.items()
    ]


def _recipe_in(folder: Path) -> Recipe | None:
    try:
        return load(folder / "recipe.json")
    except RsegenError:
        return None
