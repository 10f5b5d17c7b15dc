"""Forms for a page, each made of the one declaration that there is, and the commands that pages run by them, as jobs.

    Declared --field--> Field of a page       parser of a command --CommandForm--> fields, and values --> arguments

A command line is the form of its command: each flag, and each argument besides the recipe, is a field. A flag that is
declared has its sort, bounds and unit; any other takes a text, or is a switch. The command line is the room above this
one and starts the page, so it is found by its name, as the processes are that run its commands (`jobs.py`).
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from inspect import Parameter as Argument
from math import inf
from pathlib import Path
from typing import Any, Literal, TypedDict, cast

from rsegen import __version__
from rsegen.errors import FileError, ParameterError, UnknownName, refuse_unknown
from rsegen.measuring.catalogue import METRICS, OF_A_ROBOT, UNITS
from rsegen.obstacles import KINDS
from rsegen.obstacles.base import PLACING, own_parameters
from rsegen.page.calls import call_of_host
from rsegen.page.host import Host
from rsegen.page.places import Places, names_in
from rsegen.params.capabilities import Command, capabilities, commands
from rsegen.params.command import Declared, declared
from rsegen.params.registry import summary_of_class
from rsegen.params.sorts import FilePath, Flag, Float, Integer, Json, Parameter, Text, plain
from rsegen.recipe.examples import EXAMPLES
from rsegen.recipe.recipe import Recipe
from rsegen.recipe.recipe_file import load

_OF_A_SHELL = ("gui", "info", "examples", "obstacles", "schema", "completion", "man")
"""The commands that a page does not run: it is one of them, and shows what others print."""

_RARE = frozenset({"workers", "scheduler", "sync", "resume", "timeout", "wheels", "tracks", "size", "speed", "turn"})
"""Fields of commands that a form shows only when it is asked for more."""

_LEFT_OUT = frozenset({"help", "json", "quiet", "progress", "plugin", "list", "force", "dry_run", "verify", "rebuild"})
"""Flags that a page gives itself, and those that do something else instead."""

_LEFT_OUT_OF = {"metrics": frozenset({"csv"})}
"""A table as CSV is another form of a report than JSON, which a page reads."""

_RECIPES = ("recipe", "recipes", "target")
"""Names of the argument for which a document stands."""

_INPUTS = ("file", "clouds", "paths")
"""Names of the arguments that are files to read."""

_WORDS_OR_FILES = ("robot", "plan", "inventory", "crossable_by")
"""Names of the parameters that are a word or a file."""


@cache
def _words() -> Mapping[str, Any]:
    """Return the known words of parameters that take these or something else, such as a file, by their names."""
    places = {name: place for known in capabilities().values() for name, place in known.words.items()}
    return {
        name: getattr(import_module(place.partition(":")[0]), place.partition(":")[2]) for name, place in places.items()
    }


TITLES = {
    "maps": "Number of maps",
    "chunks": "Map size in chunks",
    "unit_cm": "Height step (unit)",
    "boundary": "Chunk boundary",
    "mesh_type": "Model mesh type",
    "by": "Metric",
    "names": "Models",
    "paths": "Scans",
    "csv": "CSV file",
    "fit": "Picture of the fit",
    "errors": "Picture of the rounding",
    "from_": "First difficulty",
    "to": "Last difficulty",
    "best": "Best way",
    "at": "Place",
}
"""Titles in the paper's words, and those that a name does not give."""

_TITLES_OF = {("rate", "by"): "Judge"}
"""Titles of parameters of single commands."""

BASIC = ("maps", "chunk_size", "chunks", "unit_cm", "boundary", "mesh_type", "seed")
"""The parameters of the paper's figure 5, and the seed."""

_GROUPS = {
    "Shape": ("block_width_cm", "frame_height_cm", "ground_level", "difficulty"),
    "Constraints": ("max_step", "crossable_by", "crossable_room", "inventory"),
    "Files and simulator": ("name", "description", "first_map", "simulator", "mesh", "collision", "tile", "units"),
    "Friction": ("friction", "frame_friction", "level_friction"),
    "Look": ("look", "frame_colour", "level_colours", "shadows", "sky"),
}
"""The titles of the other groups and their parameters; a parameter that no group has is in the last one, Other."""


JsonType = Literal["integer", "number", "string", "boolean", "array", "null"]
"""A type of JSON, as JSON Schema names it."""


class Schema(TypedDict, total=False):
    """The values of a field, in the words of JSON Schema."""

    title: str  # of one of several forms of a value
    type: JsonType | list[JsonType]
    enum: list[str]
    minimum: float
    maximum: float
    pattern: str
    minLength: int
    anyOf: list[Schema]
    items: Schema
    prefixItems: list[Schema]
    minItems: int
    maxItems: int


class OfCommand(TypedDict, total=False):
    """Additional keys of a field of a command."""

    flag: str
    required: bool  # it does not run without
    missing: str  # what to say if it is required and not given: "Choose at least one format."


class Field(OfCommand):
    """A parameter in a form: a JSON Schema property with what a form needs besides."""

    name: str
    title: str  # a word or two
    help: str
    schema: Schema
    unit: str  # "cm", "%", "units", "s", ""
    default: Json  # null: none, or decided by the program
    slider: tuple[float, float] | None  # from where to where a slider goes, if there is one
    basic: bool  # shown at once; others under "More"


class Group(TypedDict):
    """Parameters of a map, as the help has them."""

    title: str
    fields: list[Field]


class Kind(TypedDict):
    """A kind of obstacle."""

    name: str
    title: str
    help: str
    default_place: str  # where it lies without ends
    fields: list[Field]  # its own, levels and softness first
    place: list[Field]  # first, last, blend, key


class DescribedCommand(TypedDict):
    """A command that may be run."""

    name: str
    title: str  # in a menu: "Drive over a map"
    help: str
    group: str  # what it is for: "drive a robot"
    target: Literal["recipe", "none"]
    fields: list[Field]
    output: Literal["folder", "file", "none"]
    output_help: str
    output_required: bool


class Described(TypedDict):
    """An example or a format."""

    name: str
    description: str


class Titled(TypedDict):
    """A robot or a metric."""

    name: str
    title: str


class Hello(TypedDict):
    """Data that are the same for all documents."""

    version: str
    folder: str  # in which files may be read and written
    read_only: str  # why nothing can be saved in it; empty: it can
    globals: list[Group]  # the parameters of a map
    kinds: list[Kind]
    examples: list[Described]
    robots: list[Titled]
    commands: list[DescribedCommand]
    formats: list[Described]
    metrics: list[Titled]  # by which maps can be sorted


def title_of(name: str) -> str:
    """Return the title of a parameter: its name in words, without the unit."""
    bare = name.strip("_").removesuffix("_cm").removesuffix("_mm")
    return TITLES.get(name, bare.replace("_", " ").capitalize())


def metric_title(key: str) -> str:
    """Return a metric in words: its family, and what it is in it."""
    return " ".join(title_of(part).lower() for part in key.split(".")).replace(" tri", " TRI")


def field(parameter: Declared, *, basic: bool = True) -> Field:
    """Return a declared parameter as a field of a form."""
    default = None if parameter.default is Argument.empty else parameter.default
    return {
        "name": parameter.name,
        "title": title_of(parameter.name),
        "help": parameter.shell.help or parameter.sort.help or parameter.sort.describe(),
        "schema": cast(Schema, _with_words(parameter, _without_const(parameter.sort.schema()))),
        "unit": getattr(getattr(parameter.sort, "sort", parameter.sort), "unit", ""),
        "default": str(default) if isinstance(default, Path) else plain(default),
        "slider": _slider(parameter.sort),
        "basic": basic,
    }


_MOST_STEPS = 100
"""The largest difference between the ends of a slider: of more, a number that is typed is found sooner."""


def _slider(sort: Parameter) -> tuple[float, float] | None:
    """Return from where to where a slider for a number goes: over its usual range, else over all of it, if it is short.

    Values beyond the ends of a slider are typed.
    """
    if not isinstance(sort, Float | Integer):
        return None
    low, high = sort.low, inf if sort.high is None else sort.high
    return sort.usual or ((low, high) if high - low <= _MOST_STEPS else None)


def _title_of_robot(name: str, robot: Any) -> str:
    """Return a robot's name with what it is like and its size."""
    size = " × ".join(f"{100 * side:.0f}" for side in robot.size)  # noqa: RUF001  # a page has the sign
    return f"{name}: {robot.title}, {size} cm"


def _missing(made: Field) -> str:
    """Return what to say where a field that is needed is empty."""
    name, schema = made["title"].lower(), made["schema"]
    items = schema.get("items", {})
    if schema.get("type") == "array":
        verb = "Choose" if _has_words(items) else "Enter the name of"
        return f"{verb} at least one {name.removesuffix('s')}."
    article = "an" if name[0] in "aeio" else "a"
    return f"{'Choose' if _has_words(schema) else 'Enter the name of'} {article} {name}."


def _has_words(schema: Schema) -> bool:
    return "enum" in schema or any("enum" in part for part in schema.get("anyOf", []))


def _without_const(schema: Any) -> Any:
    """Return a schema in which a constant is a choice of one, so that a form knows one word less."""
    if isinstance(schema, list):
        return [_without_const(part) for part in schema]
    if not isinstance(schema, dict):
        return schema
    return {
        "enum" if name == "const" else name: [part] if name == "const" else _without_const(part)
        for name, part in schema.items()
    }


def _with_words(parameter: Declared, schema: dict[str, Json]) -> dict[str, Json]:
    """Return a schema of a text, of a list of texts, or of either, with the known words before any other text."""
    words = parameter.known_names() if parameter.known_names else _words().get(parameter.name)
    if words is None:
        return schema
    if schema.get("type") == "string":
        title = {"title": schema["title"]} if "title" in schema else {}
        return title | {"anyOf": [{"enum": sorted(words)}, {name: schema[name] for name in schema if name != "title"}]}
    if schema.get("type") == "array":
        return schema | {"items": _with_words(parameter, schema["items"])} if "items" in schema else schema
    if "anyOf" in schema:
        texts = ("string", "array")
        return schema | {
            "anyOf": [_with_words(parameter, part) if part.get("type") in texts else part for part in schema["anyOf"]]
        }
    return schema


def global_groups() -> list[Group]:
    """Return the parameters of a recipe in groups, those of the paper first."""
    known = declared(Recipe)
    grouped = {*BASIC, *(name for names in _GROUPS.values() for name in names)}
    others = tuple(name for name in known if name not in grouped)
    groups = {"Map": BASIC, **_GROUPS, **({"Other": others} if others else {})}
    return [
        {"title": title, "fields": [field(known[name], basic=name in BASIC) for name in names if name in known]}
        for title, names in groups.items()
    ]


def kinds() -> list[Kind]:
    """Return every kind of obstacle with its own parameters, levels and softness first, and those of its place."""
    return [
        {
            "name": name,
            "title": title_of(name),
            "help": summary_of_class(cls),
            "default_place": cls.default_place,
            "fields": [
                field(declared(cls)[name])
                for name in sorted(own_parameters(cls), key=lambda name: {"levels": 0, "softness": 1}.get(name, 2))
            ],
            "place": [field(declared(cls)[name], basic=name != "key") for name in PLACING],
        }
        for name, cls in KINDS.items()
    ]


@dataclass(frozen=True, kw_only=True)
class CommandForm:
    """The form of a command.

    fields: the actions of its parser that a form has, by name; output: that of the file or folder to write, if any
    takes_recipe: whether a document stands for one of its arguments
    recipe_flags: the parameters of a recipe that it has flags for, obstacles among them
    """

    name: str
    title: str
    help: str
    group: str
    fields: Mapping[str, argparse.Action]
    output: argparse.Action | None
    takes_recipe: bool
    recipe_flags: frozenset[str]
    can_replace: bool

    @classmethod
    def of(cls, known: Command, parser: Any) -> CommandForm:
        """Return the form of a command from its declaration and its parser."""
        parser.describe_flags()
        name = known.name
        actions = {action.dest: action for action in parser.actions}
        arguments = {action.dest for action in parser.actions if not action.option_strings}
        takes_recipe = name == "compare" or not arguments.isdisjoint(_RECIPES)
        of_recipe = {
            action
            for part in parser.groups
            if part.title == import_module("rsegen.cli.flags").RECIPE
            for action in part.actions
        }
        output = next((action for action in actions.values() if "--output" in action.option_strings), None)
        left_out = {*_LEFT_OUT, *_LEFT_OUT_OF.get(name, ()), *(_RECIPES if takes_recipe else ())}
        shown = {
            dest: action
            for dest, action in actions.items()
            if dest not in left_out
            and action is not output
            # A document has its own parameters; what makes a new recipe may be given some, but no obstacles as texts.
            and not (action in of_recipe and (takes_recipe or not hasattr(action, "declared")))
        }
        return cls(
            name=name,
            title=known.title or name.capitalize(),
            help=known.help,
            group=known.group,
            fields=shown,
            output=output,
            takes_recipe=takes_recipe,
            recipe_flags=frozenset(action.dest for action in of_recipe),
            can_replace="force" in actions,
        )

    @property
    def needs_output(self) -> bool:
        """Return whether it cannot do without a file or folder to write."""
        # A data set's is one of two flags of which one is needed, and the other is no field.
        return self.output is not None and (self.output.required or self.name == "dataset")

    def described(self) -> DescribedCommand:
        """Return it as pages have it."""
        return {
            "name": self.name,
            "title": self.title,
            "help": self.help,
            "group": self.group,
            "target": "recipe" if self.takes_recipe else "none",
            "fields": [self._described(action) for action in self.fields.values()],
            "output": self._output,
            "output_help": (self.output.help or "").removesuffix(" (required)") if self.output else "",
            "output_required": self.needs_output,
        }

    @property
    def _output(self) -> Literal["folder", "file", "none"]:
        if self.output is None:
            return "none"
        sort = getattr(self.output, "declared", None) and self.output.declared.sort  # type: ignore[attr-defined]
        return "file" if isinstance(sort, FilePath) and sort.meaning != FilePath.meaning else "folder"

    def _described(self, action: argparse.Action) -> Field:
        """Return an action of the parser as a field; one that is not declared is a text or a switch of its help."""
        parameter = _declaration(action)
        basic = action.dest not in _RARE and (action.dest not in declared(Recipe) or action.dest in BASIC)
        made = field(parameter, basic=basic)
        made["title"] = _TITLES_OF.get((self.name, action.dest), made["title"])
        if action.nargs == 0:
            # The help of a flag such as --no-contacts is that of switching it off.
            switched_on = parameter.sort.help or made["help"].removeprefix("do not ")
            text = switched_on if made["default"] else made["help"]
            made = {**made, "schema": {"type": "boolean"}, "default": bool(made["default"]), "help": text}
        if action.nargs == "+":
            made = {**made, "schema": {"type": "array", "items": made["schema"], "minItems": 1}}
        if action.option_strings:
            made["flag"] = action.option_strings[-1]
        if action.required:
            made["missing"] = _missing(made)
        return {**made, "required": action.required}

    def arguments(self, values: Mapping[str, Json], places: Places) -> tuple[list[str], list[str]]:
        """Return the flags and the other arguments for values by name; a ParameterError if one of them is wrong.

        places: in which all files are that are read or written
        """
        refuse_unknown(f"parameter of {self.name}", values, self.fields)
        flags: list[str] = []
        others: list[str] = []
        for name, action in self.fields.items():
            value = values.get(name)
            if value is None or value == []:
                if action.required:
                    raise ParameterError(name, self._described(action)["missing"])
            # A switch is written only if it differs from its default; the last of its flags is the one that says so.
            elif action.nargs == 0:
                is_on = _declaration(action).default is True
                flags += [action.option_strings[-1]] if Flag().check(name, value) != is_on else []
            elif action.option_strings:
                flags += [f"{action.option_strings[-1]}={text}" for text in _texts(action, value, places)]
            else:
                others += _texts(action, value, places)
        return flags, others


def _declaration(action: argparse.Action) -> Declared:
    """Return the declaration of an action; of one that has none, any text."""
    text = (action.help or "").replace("%%", "%")
    undeclared = Declared(action.dest, Text(r"[^\x00-\x1f]+", "a text", help=text), None)
    return getattr(action, "declared", undeclared)


def _texts(action: argparse.Action, value: Json, places: Places) -> Iterator[str]:
    """Yield a value as texts of a command line: several for what may be repeated, else one."""
    parameter: Declared | None = getattr(action, "declared", None)
    name = action.dest
    if parameter is None or hasattr(parameter.sort, "repeats"):
        texts = [str(text) for text in (value if isinstance(value, list) else [value])]
        for text in texts:
            _refuse_unusable(name, text)
        if parameter:
            parameter.sort.check(name, parameter.sort.parse(texts))  # type: ignore[arg-type]  # of all texts
        yield from (_placed(name, text, places) for text in texts)
        return
    if isinstance(value, str):
        value = _placed(name, value, places)  # before it is checked, which may read it
    checked = parameter.sort.check(name, value)
    listed = value if isinstance(value, list) or not isinstance(checked, tuple) else [value]
    # Without the endings of whole numbers that are floats in JSON.
    text = parameter.sort.format([plain(value) for value in listed] if isinstance(listed, list) else plain(listed))
    _refuse_unusable(name, text)
    yield _inside(name, text, places) if isinstance(parameter.sort, FilePath) else text


def _refuse_unusable(name: str, text: str) -> None:
    if not text or "\0" in text or not text.isprintable():
        raise ParameterError(name, f"{text!r} is not a text that a command line takes")


def _placed(name: str, text: str, places: Places) -> str:
    """Return a text that may name a file; a ParameterError if that file is elsewhere."""
    if name in _INPUTS:
        return _inside(name, text, places)
    return places.refuse_outside(name, text) if name in _WORDS_OR_FILES else text


def _inside(name: str, text: str, places: Places) -> str:
    try:
        return str(places.relative(places.inside(text)))
    except FileError as error:
        raise ParameterError(name, str(error)) from None


@cache
def command_forms() -> Mapping[str, CommandForm]:
    """Return the form of every command that a page may run, by its name."""
    line = import_module("rsegen.cli.parser")
    return {
        name: CommandForm.of(known, line.parser_of(name))
        for name, known in commands().items()
        if name not in _OF_A_SHELL
    }


def command_form(name: str) -> CommandForm:
    """Return the form of a command; an UnknownName, which lists the commands, if there is none."""
    if name not in command_forms():
        raise UnknownName.among("command", "command", name, command_forms())
    return command_forms()[name]


@call_of_host
def hello(host: Host) -> Hello:
    """Return what is the same for all documents: forms, kinds, robots, formats, metrics that need no robot."""
    metrics = [name for name in (*UNITS, *METRICS) if name not in OF_A_ROBOT]
    robots = {name: _title_of_robot(name, robot) for name, robot in dict(_words().get("robot", {})).items()}
    robots |= {name: name for name in names_in(host.folder) if name.endswith((".sdf", ".urdf", ".xacro"))}
    return {
        "version": __version__,
        "folder": str(host.folder.resolve()),
        "read_only": host.read_only,
        "globals": global_groups(),
        "kinds": kinds(),
        "examples": [{"name": name, "description": load(path).description} for name, path in EXAMPLES.items()],
        "robots": [{"name": name, "title": title} for name, title in robots.items()],
        "commands": [form.described() for form in command_forms().values()],
        "metrics": [{"name": name, "title": metric_title(name)} for name in metrics],
        "formats": [
            {"name": name, "description": summary_of_class(cls)}
            for name, cls in dict(_words().get("formats", {})).items()
        ],
    }
