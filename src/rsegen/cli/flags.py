"""Recipes and maps from flags: one flag for every global parameter, named after it, and --obstacle.

Commands that look at maps take where these are, or a recipe of them, and flags over it.
"""

from __future__ import annotations

import argparse
import re
import shlex
from collections.abc import Collection, Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rsegen.cli.parser import Group, Parser
from rsegen.errors import ParameterError, shown
from rsegen.params.command import Shell, add_flag, declared, given
from rsegen.params.sorts import key_values, parameters
from rsegen.recipe.recipe import Recipe

if TYPE_CHECKING:
    from rsegen.obstacles import Obstacle
    from rsegen.scene.scene import Scene
    from rsegen.writing.target_worlds import ChosenMap


RECIPE = "recipe"
"""The title of the flags that change a recipe."""

RECIPE_HELP = "YAML or JSON file, the folder of a map, the name of an example, or DIR#17: a map of a data set"


def add_input(
    group: Any, text: str = RECIPE_HELP, *, name: str = "recipe", nargs: str = "?", metavar: str = "RECIPE"
) -> None:
    """Add the argument that says where a recipe or map is, or several; a shell completes the names of examples."""
    argument: Any = group.add_argument(name, nargs=nargs, metavar=metavar, help=text)
    argument.words = _examples


def _examples() -> Collection[str]:
    from rsegen.recipe.examples import EXAMPLES

    return EXAMPLES


def add_recipe_flags(command: Parser, over: str = "RECIPE", without: Collection[str] = ()) -> None:
    """Add --obstacle and every parameter of a recipe, over what a file of that name says; some are the command's."""
    group = _recipe_group(command, f"each flag overrides the value in {over}")
    for name, parameter in declared(Recipe).items():
        if name not in without:
            shown_parameter = parameter if over == "RECIPE" and name != "seed" else parameter._replace(default=None)
            add_flag(group, shown_parameter._replace(shell=Shell(metavar=_METAVARS.get(name, ""))))


def add_target_recipe_flags(command: Parser, without: Collection[str] = ()) -> None:
    """Add these flags to a command that looks at maps; the help shows two, and says where the others are."""
    text = "each flag overrides the value in RECIPE-or-DIR; rsegen generate --help lists all parameters of a recipe"
    group = _recipe_group(command, text)
    for name, parameter in declared(Recipe).items():
        if name not in without:
            add_flag(group, parameter, parameter.sort.help if name == "seed" else argparse.SUPPRESS)


def _recipe_group(command: Parser, text: str) -> Group:
    """Return a new group of flags of a recipe, which has --obstacle."""
    group = command.group(RECIPE, text)
    example = "add an obstacle, as in 'peak levels=5 softness=30 first=2,2 last=7,7'; may be repeated"
    row: Any = group.add_argument(
        "--obstacle", action="append", default=[], metavar="'KIND KEY=VALUE ...'", help=example
    )
    row.completer = _obstacles
    return group


def _obstacles(*, prefix: str, **_: object) -> Iterable[str]:
    """Return what may stand in a row of an obstacle: a kind, or behind it the parameters."""
    from rsegen.obstacles.base import KINDS, row_parameters

    kind, *values = prefix.split(" ")
    if not values:
        return KINDS
    names = row_parameters(KINDS[kind]) if kind in KINDS else ()
    return [f"{prefix.rpartition(' ')[0]} {name}=" for name in names]


def recipe_from(arguments: argparse.Namespace, without: Collection[str] = ()) -> Recipe:
    """Return the recipe of the file, if one is given, with the flags over it and their obstacles after its own.

    without: flags that are the command's own
    """
    from rsegen.recipe.recipe_file import named_recipe

    start = Recipe() if arguments.recipe is None else named_recipe(arguments.recipe)
    return with_flags(start, _without(arguments, without) if without else arguments)


def _without(arguments: argparse.Namespace, own: Collection[str]) -> argparse.Namespace:
    """Return arguments without some flags, which are the command's own."""
    return argparse.Namespace(**{name: value for name, value in vars(arguments).items() if name not in own})


def has_recipe_flags(arguments: argparse.Namespace) -> bool:
    """Return whether any flag says something of the recipe."""
    return bool(arguments.obstacle or recipe_flags(arguments))


def recipe_flags(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return what the flags say of a recipe, not yet checked."""
    return given(Recipe, arguments, getattr(arguments, "units", None))


def with_flags(start: Recipe, arguments: argparse.Namespace) -> Recipe:
    """Return a recipe with the flags over it and their obstacles after its own."""
    added = tuple(obstacle_in(text) for text in arguments.obstacle)
    given_flags = recipe_flags(arguments)
    if not (added or given_flags):
        return start  # a recipe that is changed is checked anew, which takes long for a large one
    from rsegen.recipe.recipe_file import answered

    match given_flags:
        case {"inventory": [str(name)]} if name:  # a file: numbers would have been parsed as numbers
            from rsegen.recipe.inventory_file import inventory_in

            unit = parameters(Recipe)["unit_cm"].check("unit_cm", given_flags.get("unit_cm", start.unit_cm))
            given_flags["inventory"] = inventory_in(Path(name), unit)
    try:
        obstacles = (*start.obstacles, *added)
        return answered(lambda values: replace(start, **values, obstacles=obstacles), given_flags)
    except ParameterError as error:
        # An obstacle of a flag is named by its flag; its row in the joined list is nowhere to be seen.
        place = re.match(r"obstacles\[(\d+)\]\.?", error.where)
        if place is None or (row := int(place[1]) - len(start.obstacles)) < 0:
            raise
        of_obstacle = ParameterError(error.where[place.end() :], error.problem)
        raise of_obstacle.of(_obstacle_flag(arguments.obstacle[row])) from None


def _obstacle_flag(text: str) -> str:
    """Return the flag of an obstacle, as messages name it."""
    return f"--obstacle {shown(text)}"


_BLANKS_OF_LISTS = re.compile(r"(?<=[\[,])\s+|\s+(?=[],])")
"""Blanks in lists as recipes and the help have them, `first=[2, 2]`."""


def obstacle_in(text: str) -> Obstacle:
    """Return the obstacle that a text such as `peak levels=5 first=2,2` stands for."""
    from rsegen.obstacles import KINDS
    from rsegen.recipe.codec import decode_obstacle

    where = _obstacle_flag(text)
    try:
        name, *pairs = shlex.split(text if "'" in text or '"' in text else _BLANKS_OF_LISTS.sub("", text))
    except ValueError:
        raise ParameterError(where, "expected a kind and then KEY=VALUE, as in 'peak levels=5'") from None
    try:
        values = key_values(pairs, parameters(KINDS.named(name, "")))
        if "kind" in values:
            raise ParameterError("kind", "is given twice")
        return decode_obstacle({"kind": name, **values})
    except ParameterError as error:
        raise error.of(where) from None


_METAVARS = {
    "chunks": "N|NxM",
    "name": "NAME",
    "description": "TEXT",
    "first_map": "INDEX",
    "level_friction": "N,N,...",
    "frame_colour": "'#RRGGBB'",
    "level_colours": "'#RRGGBB,...'",
    "crossable_by": "ROBOT[:CERTAINTY]|CM,CM,CM",
    "inventory": "FILE.csv|N,N,...",
}


_WHERE = "a recipe (YAML, JSON), the name of an example, the folder of a map, a folder of maps, or DIR#17 of a data set"


def add_target_flags(command: Parser, default: str = "the first") -> None:
    """Add where to look, and which map; `add_target_recipe_flags` adds what makes a map of flags alone."""
    group = command.group("input")
    add_input(group, f"{_WHERE}; leave it out if you use --obstacle", name="target", metavar="RECIPE-or-DIR")
    group.add_argument("--map", metavar="INDEX", help=f"index or name of the map (default: {default})")


def is_of_flags(arguments: argparse.Namespace) -> bool:
    """Return whether a map is to be made of flags, alone or over a target's; ParameterError if nothing is given."""
    if arguments.target is None and not arguments.obstacle:
        raise ParameterError("RECIPE", "no input; pass a recipe, a folder or --obstacle 'random levels=5'")
    return has_recipe_flags(arguments)


def recipes_of(arguments: argparse.Namespace) -> Iterator[tuple[Path, Recipe]]:
    """Yield each recipe of the target with the flags over it, and its file; without a target the flags' recipe."""
    from rsegen.recipe.recipe_file import recipe_in
    from rsegen.writing.target_worlds import recipe_files

    flags, target = is_of_flags(arguments), arguments.target
    if target is None:
        yield Path(), with_flags(Recipe(), arguments)
        return
    for file in recipe_files(target):
        recipe = recipe_in(file)
        yield file, with_flags(recipe, arguments) if flags else recipe


def map_of_flags(arguments: argparse.Namespace) -> ChosenMap:
    """Return one map of them: the one that --map names, or the first."""
    from rsegen.writing.target_worlds import one_of

    return one_of(recipes_of(arguments), arguments.map, arguments.target or "the recipe of the flags", "--map")


def maps_of_flags(arguments: argparse.Namespace) -> Iterator[Recipe]:
    """Yield the recipes of all their maps, or of the one that --map names."""
    if arguments.map is None:
        yield from (recipe for _, recipe in recipes_of(arguments))
        return
    _, recipe, index = map_of_flags(arguments)
    yield recipe.alone(index)


def target_of(arguments: argparse.Namespace, without: Collection[str] = ()) -> Recipe | str:
    """Return the target as given, or the recipe of one map if flags make one; some flags are the command's own."""
    others = _without(arguments, without)
    if not is_of_flags(others):
        return str(arguments.target)
    _, recipe, index = map_of_flags(others)
    return recipe.alone(index)


def scene_of_flags(arguments: argparse.Namespace) -> Scene:
    """Return the scene of that map."""
    from rsegen.scene.scene import compose
    from rsegen.writing.resources import refuse_too_large

    _, recipe, index = map_of_flags(arguments)
    refuse_too_large(recipe)
    return compose(recipe, index)


def which_map(target: str | None, which: str | None) -> Iterator[str]:
    """Yield a line on the map that a command took, if it is the first of a folder and nobody chose it."""
    from rsegen.writing.target_worlds import recipe_files

    files = recipe_files(target) if target is not None and which is None else []
    if len(files) > 1:
        yield f"note: {files[0].parent.name} is the first of {len(files)} maps in {target}; --map selects another"
