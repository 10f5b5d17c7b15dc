"""From flags to a recipe: one flag for every global parameter, named after it."""

from __future__ import annotations

import argparse
import os.path
import shlex
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeAlias

from rsegen.cli.inventory import inventory_in
from rsegen.errors import FileError, ParameterError, shown
from rsegen.field.obstacles import kind
from rsegen.io.dataset.map_reference import recipe_in
from rsegen.params.sorts import parameters
from rsegen.recipe.codec import OTHER_NAMES, decode_placement
from rsegen.recipe.examples import or_example
from rsegen.recipe.recipe import Placement, Recipe
from rsegen.simulation.robots import robot

Subparsers: TypeAlias = "argparse._SubParsersAction[argparse.ArgumentParser]"

OBSTACLE_HELP = "add an obstacle, as in 'peak max_height=5 softness=30 first=2,2 last=7,7'; may be repeated"


RECIPE_HELP = "YAML or JSON file, the folder of a map, the name of an example, or DIR#17: a map of a data set"


def folder(text: str) -> Path:
    """The folder that a flag names."""
    if not text:
        raise argparse.ArgumentTypeError("nothing is given; give a folder, as in -o worlds")
    return Path(text)


def add_recipe_flags(command: argparse.ArgumentParser, over: str = "RECIPE") -> None:
    """Every global parameter and `--obstacle`, over what a file of that name says."""
    group = command.add_argument_group("recipe", f"each overrides what {over} says")
    untold = ("seed", "description") if over == "RECIPE" else parameters(Recipe)
    defaults = Recipe(seed=0)
    usual = {name: getattr(defaults, name) for name in parameters(Recipe) if name not in untold}
    add_parameter_flags(group, Recipe, usual)
    group.add_argument("--obstacle", action="append", default=[], metavar="'KIND KEY=VALUE ...'", help=OBSTACLE_HELP)


def add_parameter_flags(
    command: argparse._ActionsContainer, owner: type, usual: Mapping[str, object] = MappingProxyType({})
) -> None:
    """Every parameter of a dataclass, with the value that it usually has, where that is to be told."""
    for name, parameter in parameters(owner).items():
        told = f", {_plain(usual[name])} by default" if name in usual else ""
        text = f"{parameter.help} ({parameter.describe()}{told})".replace("%", "%%")
        command.add_argument(flag(name), dest=name, metavar=_metavar(name), help=text)


def flag(name: str) -> str:
    """The flag of a parameter."""
    return f"--{name.replace('_', '-')}"


def recipe_from(arguments: argparse.Namespace) -> Recipe:
    """The recipe of the file, if one is given, with the flags over it and their obstacles after its own."""
    return with_flags(Recipe() if arguments.recipe is None else recipe_in(_file(arguments.recipe)), arguments)


def with_flags(start: Recipe, arguments: argparse.Namespace) -> Recipe:
    """A recipe with the flags over it and their obstacles after its own."""
    added = tuple(placement(text) for text in arguments.obstacle)
    said = _without_names(given(Recipe, arguments), start.unit_cm)
    return replace(start, **said, obstacles=(*start.obstacles, *added))


def _without_names(said: dict[str, Any], unit_cm: float) -> dict[str, Any]:
    """What flags say, with a robot's figures in place of its name, and a file's blocks in place of the file."""
    match said:
        case {"crossable_by": [str(name)]} if name:
            said["crossable_by"] = robot(name, "crossable_by").climber.figures
    match said:
        case {"inventory": [str(name)]} if name:
            unit = parameters(Recipe)["unit_cm"].check("unit_cm", said.get("unit_cm", unit_cm))
            said["inventory"] = inventory_in(Path(name), unit)
    return said


def given(owner: type, arguments: argparse.Namespace) -> dict[str, Any]:
    """What the flags say of the parameters of a dataclass; not yet checked."""
    texts = {name: getattr(arguments, name, None) for name in parameters(owner)}
    return {name: parameters(owner)[name].parse(text) for name, text in texts.items() if text is not None}


def placement(text: str) -> Placement:
    """The obstacle that a text such as `peak max_height=5 first=2,2` stands for."""
    try:
        return decode_placement(_entry(text))
    except ParameterError as error:
        raise error.of(f"--obstacle {shown(text)}") from None


def _entry(text: str) -> dict[str, object]:
    try:
        name, *pairs = shlex.split(text)
    except ValueError:
        raise ParameterError("", "give a kind and then KEY=VALUE, as in 'peak max_height=5'") from None
    sorts = {**parameters(kind(name, "")), **parameters(Placement)}
    sorts = {other: sorts[first] for other, first in OTHER_NAMES.items()} | sorts
    entry: dict[str, object] = {"kind": name}
    for pair in pairs:
        key, equals, value = pair.partition("=")
        if not equals:
            raise ParameterError("", f"{shown(pair)} is not KEY=VALUE")
        if key in entry:
            raise ParameterError(key, "is given twice")
        entry[key] = sorts[key].parse(value) if key in sorts else value
    return entry


def _file(text: str) -> Path:
    if not os.path.isdir(text):
        return or_example(text)
    path = Path(text) / "recipe.json"
    if not path.is_file():
        raise FileError(
            f"{text}: a folder without a recipe.json; give a recipe file, the folder of a map, or DIR#0 of a data set"
        )
    return path


def _metavar(name: str) -> str:
    return _METAVARS.get(name, name.rpartition("_")[2].upper())


def _plain(value: object) -> str:
    if isinstance(value, tuple):
        return "x".join(map(str, value))
    return f"{value:g}" if isinstance(value, float) else str(value)


_METAVARS = {
    "chunks": "N|NxM",
    "name": "NAME",
    "description": "TEXT",
    "first_map": "INDEX",
    "level_friction": "N,N,...",
    "frame_colour": "'#RRGGBB'",
    "level_colours": "'#RRGGBB,...'",
    "crossable_by": "ROBOT|CM,CM,CM",
    "inventory": "FILE.csv|N,N,...",
}
