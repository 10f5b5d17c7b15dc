"""`rsegen.respawn` and `rsegen.remove`: the map of a running simulation replaced at its pose, and models deleted.

The map to replace is the one of the same recipes, else the only one whose recipe is known; the new one is the next in
the folder, or the next index of the recipe. The new map comes before the old one goes, so nothing falls meanwhile.
"""

from __future__ import annotations

import os
import os.path
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from rsegen.errors import ParameterError, UnknownName, shown
from rsegen.exporters.scene import Scene, compose
from rsegen.field.stepfield import StepField
from rsegen.io.targets import recipe_files, recipe_in
from rsegen.recipe.recipe import Recipe
from rsegen.simulation.simulators.connecting import connected
from rsegen.simulation.simulators.live_world import Pose
from rsegen.simulation.spawning.spawning import (
    MapModel,
    SpawnedMap,
    known_recipes,
    map_model,
    map_of,
    maps_in,
    spawn_map,
)
from rsegen.simulation.worlds import Target


@dataclass(frozen=True, kw_only=True, slots=True)
class RespawnResult:
    """The result of `rsegen.respawn`: names of the new and the old map, simulator, pose, and models put on top."""

    name: str
    instead_of: str
    simulator: str
    at: Pose
    put_on_top: tuple[str, ...] = ()


def replace_map(  # as `rsegen.respawn`
    target: Target, which: int | str | None, name: str | None, output: Path, simulator: str | None, timeout: float
) -> RespawnResult:
    """Replace the map in the simulation by another one, by default the next; see `rsegen.respawn`."""
    recipes = _recipes(target)
    with connected(simulator, timeout) as (running, live):
        poses = live.poses()
        known = known_recipes(live, poses, [output, *_homes(target)])
        current = _current_map(poses, {recipe.name for recipe in recipes}, known, name)
        new = _given_or_next(target, which, output, current)
        new.check_spawnable()
        if new.name in poses:
            what = f"{shown(new.name)} exists already; give another"
            if which is None and new.name == current:
                what = f"{shown(current)} is in the simulation, and {shown(str(target))} has no other map"
            raise ParameterError("" if which is None else "map", what)
        recipe = known.get(current)
        field = compose(recipe, recipe.first_map).field if recipe else _field(recipes[0], current)
        old = SpawnedMap(name=current, field=field, at=poses[current])
        moved = spawn_map(live, new.sdf(new.name), SpawnedMap(name=new.name, field=new.field, at=old.at), old)
    return RespawnResult(name=new.name, instead_of=current, simulator=running.name, at=old.at, put_on_top=moved)


def _recipes(target: Target) -> list[Recipe]:
    if isinstance(target, Scene):
        return [target.recipe]
    if isinstance(target, Recipe):
        return [target]
    return [recipe_in(file) for file in recipe_files(os.fspath(target))]


def _homes(target: Target) -> list[Path]:
    """Folders in which the folder of a running map may be."""
    path = Path(target) if isinstance(target, str | os.PathLike) else None
    return [path, path.parent] if path and path.is_dir() else []


def _current_map(poses: Mapping[str, Pose], stems: set[str], known: Iterable[str], given: str | None) -> str:
    """Return the name of the map that is to be replaced: one of the same recipes, else any other map that is known."""
    models = ", ".join(sorted(poses))
    if given is not None:
        if given not in poses:
            raise ParameterError("name", f"no model {shown(given)} in the simulation (models: {models})")
        return given
    pattern = "|".join(rf"{re.escape(stem)}_\d{{4,}}" for stem in sorted(stems))
    candidates = sorted(name for name in poses if re.fullmatch(pattern, name)) or sorted(known)
    if not candidates:
        what = " or ".join(f"{stem}_0000" for stem in sorted(stems))
        raise ParameterError("", f"no map such as {what} in the simulation (models: {models})")
    if len(candidates) > 1:
        raise ParameterError("name", f"several maps could be replaced; give one of {', '.join(candidates)}")
    return candidates[0]


def _given_or_next(target: Target, which: int | str | None, output: Path, current: str) -> MapModel:
    """Return the given map, else the one after the current map, in the folder or by its index."""
    if which is not None or isinstance(target, Scene):
        return map_of(target, which, output)
    if not isinstance(target, Recipe) and os.path.isdir(target):
        maps = maps_in(os.fspath(target))
        names = [model.name for model in maps]
        return maps[(names.index(current) + 1) % len(maps)] if current in names else maps[0]
    (recipe,) = _recipes(target)
    index = _index(recipe, current)
    return map_model(recipe, recipe.first_map if index is None else index + 1, output)


def _index(recipe: Recipe, name: str) -> int | None:
    """Return the index of the map of this name."""
    digits = name.removeprefix(f"{recipe.name}_")
    return int(digits) if digits.isdecimal() and recipe.map_name(int(digits)) == name else None


def _field(recipe: Recipe, name: str) -> StepField:
    """Return the blocks of a map whose folder is unknown: those that the recipe gives for its index."""
    return compose(recipe, _index(recipe, name) or recipe.first_map).field


@dataclass(frozen=True, kw_only=True, slots=True)
class RemoveResult:
    """The result of `rsegen.remove`: the names of the deleted models, and the simulator's."""

    removed: tuple[str, ...]
    simulator: str


def remove_models(names: Sequence[str], simulator: str | None, timeout: float) -> RemoveResult:
    """Delete models, or none of them if one does not exist; see `rsegen.remove`."""
    if not names:
        raise ParameterError("names", "nothing is given; give the names of models in the simulation")
    unique = tuple(dict.fromkeys(names))
    with connected(simulator, timeout) as (running, live):
        models = live.poses()
        for name in unique:
            if name not in models:
                raise UnknownName.among("", "model", name, models)
        for name in unique:
            live.delete(name)
    return RemoveResult(removed=unique, simulator=running.name)
