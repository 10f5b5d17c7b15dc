"""rsegen respawn: the map of a running simulation replaced by the next one."""

from __future__ import annotations

import argparse
import json
import os.path
import re
from collections.abc import Mapping
from dataclasses import asdict

from rsegen.cli.flags import Subparsers
from rsegen.cli.maps import add_output_flag, add_running_flags, map_of, maps_in
from rsegen.cli.targets import recipe_files
from rsegen.errors import ParameterError, shown
from rsegen.exporters.gazebo.sdf import numbers
from rsegen.exporters.scene import compose
from rsegen.field.stepfield import StepField
from rsegen.io.dataset.map_reference import recipe_in
from rsegen.recipe.recipe import Recipe
from rsegen.simulation.simulators.connecting import joined
from rsegen.simulation.simulators.live import Pose
from rsegen.simulation.spawning.change import put
from rsegen.simulation.spawning.maps import Map, known, made
from rsegen.simulation.spawning.spawned_map import Placed


def add(commands: Subparsers) -> None:
    """The parser of this command."""
    command = commands.add_parser(
        "respawn",
        help="replace the map of the simulation that runs by the next one",
        description="Replace the map of the simulation that runs by the next one, at the same place. Robots and their "
        "programs go on; whatever stands on the map is put on top of the new blocks, while time stands still.",
    )
    where = "the recipe of the map that is there, or the folder of its maps; after the last of a folder comes the first"
    command.add_argument("target", metavar="RECIPE-or-DIR", help=where)
    command.add_argument("--map", metavar="INDEX", help="which map, by its index or its name (default: the next)")
    command.add_argument("--name", help="which model is replaced, where several could be meant")
    add_output_flag(command)
    add_running_flags(command)
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Replace it, and say what was done."""
    recipes = [recipe_in(file) for file in recipe_files(arguments.target)]
    with joined(arguments.simulator) as (simulator, live):
        poses = live.poses()
        name = _there(poses, {recipe.name for recipe in recipes}, arguments.name)
        new = _given_or_next(arguments, name)
        new.refuse_unfit(simulator)
        if new.name in poses:
            raise ParameterError("--map", f"{shown(new.name)} is there already; give another")
        before = known({name: poses[name]}, [arguments.output, new.folder.parent])
        old = before[0] if before else Placed(name=name, field=_field(recipes[0], name), at=poses[name])
        moved = put(live, new.model(new.name), Placed(name=new.name, field=new.field, at=old.at), old)
    told = {
        "name": new.name,
        "instead_of": name,
        "simulator": simulator.name,
        "at": asdict(old.at),
        "put_on_top": moved,
    }
    print(json.dumps(told, indent=2) if arguments.json else _line(new.name, name, old.at, moved))


def _there(poses: Mapping[str, Pose], stems: set[str], given: str | None) -> str:
    """The name of the map that is to be replaced."""
    if given is not None:
        if given not in poses:
            raise ParameterError("--name", f"{shown(given)} is not there (there are: {', '.join(sorted(poses))})")
        return given
    pattern = "|".join(rf"{re.escape(stem)}_\d{{4,}}" for stem in sorted(stems))
    found = sorted(name for name in poses if re.fullmatch(pattern, name))
    if not found:
        what = " or ".join(f"{stem}_0000" for stem in sorted(stems))
        raise ParameterError("", f"no map such as {what} is there (there are: {', '.join(sorted(poses))})")
    if len(found) > 1:
        raise ParameterError("--name", f"say which is to be replaced: {', '.join(found)}")
    return found[0]


def _given_or_next(arguments: argparse.Namespace, name: str) -> Map:
    """The map that is asked for; else the one after the one that is there, in the folder or by its index."""
    if arguments.map is not None:
        return map_of(arguments.target, arguments.map, arguments.output)
    if os.path.isdir(arguments.target):
        maps = maps_in(arguments.target)
        names = [one.name for one in maps]
        return maps[(names.index(name) + 1) % len(maps)] if name in names else maps[0]
    recipe = recipe_in(arguments.target)
    index = _index(recipe, name)
    return made(recipe, recipe.first_map if index is None else index + 1, arguments.output)


def _index(recipe: Recipe, name: str) -> int | None:
    """Which map of a recipe is called so."""
    digits = name.removeprefix(f"{recipe.name}_")
    return int(digits) if digits.isdecimal() and recipe.map_name(int(digits)) == name else None


def _field(recipe: Recipe, name: str) -> StepField:
    """The blocks of a map whose folder nobody knows; they are of this recipe, if of any."""
    return compose(recipe, _index(recipe, name) or recipe.first_map).field


def _line(new: str, old: str, at: Pose, moved: list[str]) -> str:
    on_top = f"; put on top of it: {', '.join(moved)}" if moved else ""
    return f"{new} is there instead of {old}, at {numbers([at.x, at.y, at.z])}{on_top}"
