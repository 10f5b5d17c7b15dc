"""The flags of commands that look at maps: where the maps are or a recipe of them, and the maps that they stand for."""

from __future__ import annotations

import argparse
from collections.abc import Collection, Iterator
from pathlib import Path

from rsegen.cli.flags import has_recipe_flags, with_flags
from rsegen.errors import ParameterError
from rsegen.exporters.formats import Step
from rsegen.exporters.scene import Scene, compose
from rsegen.io.resources import refuse_too_large
from rsegen.io.targets import ChosenMap, one_of, recipe_files, recipe_in
from rsegen.recipe.recipe import Recipe

_WHERE = "a recipe (YAML, JSON), the name of an example, the folder of a map, a folder of maps, or DIR#17 of a data set"


def add_target_flags(
    command: argparse.ArgumentParser,
    usual: str = "the first",
    *,
    metavar: str = "RECIPE-or-DIR",
    where: str = _WHERE,
) -> None:
    """Where to look, and which map; `add_target_recipe_flags` adds what makes a map without anything to look at."""
    group = command.add_argument_group("input")
    group.add_argument("target", nargs="?", metavar=metavar, help=f"{where}; or none, but --obstacle")
    group.add_argument("--map", metavar="INDEX", help=f"which map, by its index or its name (default: {usual})")


def is_of_flags(arguments: argparse.Namespace) -> bool:
    """Whether a map is to be made of flags, alone or over those of the target; ParameterError if nothing is given."""
    if arguments.target is None and not arguments.obstacle:
        raise ParameterError("RECIPE", "nothing is given; give a recipe, a folder or --obstacle 'random levels=5'")
    return has_recipe_flags(arguments)


def recipes_of(arguments: argparse.Namespace) -> Iterator[tuple[Path, Recipe]]:
    """Each recipe of the target with the flags over it, and its file; that of the flags alone without a target."""
    flags, target = is_of_flags(arguments), arguments.target
    if target is None:
        yield Path(), with_flags(Recipe(), arguments)
        return
    for file in recipe_files(target):
        recipe = recipe_in(file)
        yield file, with_flags(recipe, arguments) if flags else recipe


def map_of_flags(arguments: argparse.Namespace) -> ChosenMap:
    """One map of them: the one that --map names, or the first."""
    return one_of(recipes_of(arguments), arguments.map, arguments.target or "the recipe of the flags")


def target_of(arguments: argparse.Namespace, without: Collection[str] = ()) -> Recipe | str:
    """The target as it is given, or the recipe of one map if flags make one; some flags are the command's own."""
    own = argparse.Namespace(**{name: value for name, value in vars(arguments).items() if name not in without})
    if not is_of_flags(own):
        return str(arguments.target)
    _, recipe, index = map_of_flags(own)
    return recipe.alone(index)


def scene_of(arguments: argparse.Namespace) -> Scene:
    """The scene of that map."""
    _, recipe, index = map_of_flags(arguments)
    refuse_too_large(recipe)
    return compose(recipe, index)


def scenes_of(arguments: argparse.Namespace, step: Step = "build") -> Iterator[Scene]:
    """The scenes of all of them one by one, or of the one that --map names; `step` needs the most memory."""
    if arguments.map is not None:
        _, recipe, index = map_of_flags(arguments)
        refuse_too_large(recipe, step)
        yield compose(recipe, index)
        return
    for _, recipe in recipes_of(arguments):
        refuse_too_large(recipe, step)
        yield from (compose(recipe, index) for index in recipe.indices)
