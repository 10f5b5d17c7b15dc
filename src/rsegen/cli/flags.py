"""From flags to a recipe: one flag for every global parameter, named after it."""

from __future__ import annotations

import argparse
import os.path
import shlex
from collections.abc import Collection, Mapping, Sequence
from dataclasses import MISSING, fields, replace
from pathlib import Path
from typing import Any, TypeAlias

from rsegen.cli.key_values import key_values
from rsegen.cli.parser import Parser
from rsegen.errors import FileError, ParameterError, shown
from rsegen.field.obstacles import Obstacle, kind
from rsegen.field.obstacles.base import row_parameters
from rsegen.io.targets import recipe_in
from rsegen.params.sorts import Choice, Flag, Parameter, parameters, with_lengths
from rsegen.recipe.codec import decode_obstacle
from rsegen.recipe.examples import or_example
from rsegen.recipe.recipe import Recipe

Subparsers: TypeAlias = "argparse._SubParsersAction[Parser]"

_OBSTACLE = "'KIND KEY=VALUE ...'"
OBSTACLE_HELP = "add an obstacle, as in 'peak levels=5 softness=30 first=2,2 last=7,7'; may be repeated"

RECIPE_HELP = "YAML or JSON file, the folder of a map, the name of an example, or DIR#17: a map of a data set"


def folder(text: str) -> Path:
    """The folder that a flag names."""
    if not text:
        raise argparse.ArgumentTypeError("nothing is given; give a folder, as in -o worlds")
    return Path(text)


def add_force_flag(group: argparse._ActionsContainer, what: str, when: str = "") -> None:
    """`--force`, which means the same in every command."""
    text = f"replace {what} that rsegen wrote and nobody has changed since{when}"
    group.add_argument("--force", action="store_true", help=text)


def add_recipe_flags(command: Parser, over: str = "RECIPE") -> None:
    """`--obstacle` and every parameter of a recipe, over what a file of that name says."""
    group = command.add_argument_group("recipe", f"each overrides what {over} says")
    group.add_argument("--obstacle", action="append", default=[], metavar=_OBSTACLE, help=OBSTACLE_HELP)
    known, recipe = parameters(Recipe), Recipe(seed=0)
    defaults = {name: getattr(recipe, name) for name in known if name != "seed"}
    _add_flags(group, known, defaults if over == "RECIPE" else {})


def add_target_recipe_flags(command: Parser, without: Collection[str] = ()) -> None:
    """The same for commands that look at maps, but for some; the help shows two and says where the others are."""
    text = "each overrides what RECIPE-or-DIR says; rsegen generate --help lists all the others of a recipe"
    group = command.add_argument_group("recipe", text)
    group.add_argument("--obstacle", action="append", default=[], metavar=_OBSTACLE, help=OBSTACLE_HELP)
    for name, parameter in parameters(Recipe).items():
        if name not in without:
            text = parameter.help if name == "seed" else argparse.SUPPRESS
            group.add_argument(flag(name), dest=name, metavar=_metavar(name), help=text)


def add_parameter_flags(command: argparse._ActionsContainer, owner: Any, without: Collection[str] = ()) -> None:
    """A flag for every parameter of a dataclass, but for some, with its default."""
    known = {name: parameter for name, parameter in parameters(owner).items() if name not in without}
    _add_flags(command, known, {field.name: field.default for field in fields(owner)})


def _add_flags(
    command: argparse._ActionsContainer, known: Mapping[str, Parameter], defaults: Mapping[str, object]
) -> None:
    for name, parameter in known.items():
        metavar, text = describe_flag(name, parameter, defaults.get(name))
        command.add_argument(flag(name), dest=name, metavar=metavar, help=text)


def add_switch(command: argparse._ActionsContainer, name: str, text: str) -> None:
    """A flag without a value that says yes to a parameter."""
    command.add_argument(flag(name), dest=name, action="store_const", const="yes", help=text)


def describe_flag(name: str, parameter: Parameter, default: object = None) -> tuple[str, str]:
    """How the help shows the value of a flag, and what it says of it: meaning, values, default; the last two once."""
    words = _words(parameter)
    notes = [] if words else [parameter.describe()]
    if default not in (None, "", MISSING):
        notes.append(f"default: {_plain(default)}")
    text = f"{parameter.help} ({'; '.join(notes)})" if notes else parameter.help
    return f"{{{','.join(words)}}}" if words else _metavar(name), text.replace("%", "%%")


def _words(parameter: Parameter) -> tuple[str, ...]:
    """The few words that a parameter takes, if it takes no other values."""
    match parameter:
        case Choice(values=values):
            return values
        case Flag():
            return ("yes", "no")
    return ()


def flag(name: str) -> str:
    """The flag of a parameter."""
    return f"--{name.replace('_', '-')}"


def recipe_from(arguments: argparse.Namespace) -> Recipe:
    """The recipe of the file, if one is given, with the flags over it and their obstacles after its own."""
    return recipes_from([] if arguments.recipe is None else [arguments.recipe], arguments)[0]


def recipes_from(names: Sequence[str], arguments: argparse.Namespace) -> list[Recipe]:
    """The recipes of these files, or one of flags alone if there are none, each with the flags over it."""
    starts = [recipe_in(_file(name)) for name in names] or [Recipe()]
    return [with_flags(start, arguments) for start in starts]


def has_recipe_flags(arguments: argparse.Namespace) -> bool:
    """Whether any flag says something of the recipe."""
    return bool(arguments.obstacle or given(Recipe, arguments))


def with_flags(start: Recipe, arguments: argparse.Namespace) -> Recipe:
    """A recipe with the flags over it and their obstacles after its own."""
    added = tuple(obstacle(text) for text in arguments.obstacle)
    said = _without_names(given(Recipe, arguments), start.unit_cm)
    return replace(start, **said, obstacles=(*start.obstacles, *added))


def _without_names(said: dict[str, Any], unit_cm: float) -> dict[str, Any]:
    """What flags say, with a robot's figures in place of its name, and a file's blocks in place of the file."""
    match said:
        case {"crossable_by": [str(name)]} if name:
            from rsegen.robots import robot

            said["crossable_by"] = robot(name, "crossable_by").climber.figures
    match said:
        case {"inventory": [str(name)]} if name:
            from rsegen.cli.inventory import inventory_in

            unit = parameters(Recipe)["unit_cm"].check("unit_cm", said.get("unit_cm", unit_cm))
            said["inventory"] = inventory_in(Path(name), unit)
    return said


def given(owner: type, arguments: argparse.Namespace) -> dict[str, Any]:
    """What the flags say of the parameters of a dataclass; not yet checked."""
    texts = {name: getattr(arguments, name, None) for name in parameters(owner)}
    units = getattr(arguments, "units", None)
    return {
        name: parameter.parse(with_lengths(text, parameter, name, units=units))
        for name, parameter in parameters(owner).items()
        if (text := texts[name]) is not None
    }


def obstacle(text: str) -> Obstacle:
    """Return the obstacle that a text such as `peak levels=5 first=2,2` stands for."""
    try:
        return decode_obstacle(_entry(text))
    except ParameterError as error:
        raise error.of(f"--obstacle {shown(text)}") from None


def _entry(text: str) -> dict[str, object]:
    try:
        name, *pairs = shlex.split(text)
    except ValueError:
        raise ParameterError("", "give a kind and then KEY=VALUE, as in 'peak levels=5'") from None
    values = key_values(pairs, row_parameters(kind(name, "")))
    if "kind" in values:
        raise ParameterError("kind", "is given twice")
    return {"kind": name, **values}


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
    """A default as a person gives it."""
    if isinstance(value, bool):
        return "yes" if value else "no"
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
