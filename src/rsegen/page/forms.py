"""Forms of a page, made of the declarations of parameters: a field for each of them.

    Declared --field--> Field of a page       parameters of a recipe --global_groups--> fields in groups

A field has its title in words, the JSON Schema of its sort, unit, default, and a slider, if its range is short. Of
commands `command_forms.py` makes the forms.
"""

from __future__ import annotations

from inspect import Parameter as Argument
from math import inf
from pathlib import Path
from typing import Any, Literal, TypedDict, cast

from rsegen.obstacles import KINDS
from rsegen.obstacles.base import PLACING, own_parameters
from rsegen.params.capabilities import known_words
from rsegen.params.command import Declared, declared
from rsegen.params.registry import summary_of_class
from rsegen.params.sorts import Float, Integer, Json, Parameter, plain
from rsegen.recipe.recipe import Recipe

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

BASIC = ("maps", "chunk_size", "chunks", "unit_cm", "boundary", "mesh_type", "seed")
"""The parameters of the paper's figure 5, and the seed."""

_GROUPS = {
    "Shape": ("block_width_cm", "frame_height_cm", "ground_level", "difficulty"),
    "Constraints": ("max_step", "crossable_by", "crossable_room", "inventory"),
    "Files and simulator": (
        "name",
        "description",
        "first_map",
        "simulator",
        "solver",
        "mesh",
        "collision",
        "tile",
        "units",
    ),
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
    text = parameter.shell.help or parameter.sort.help or parameter.sort.describe()
    return {
        "name": parameter.name,
        "title": title_of(parameter.name),
        "help": f"{text}; default: {parameter.shell.default}" if parameter.shell.default else text,
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
    known = parameter.known_names or known_words().get(parameter.name)
    words = known() if known else ()
    if not words:
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
    """Return the parameters of a recipe in groups, the paper's first."""
    known = declared(Recipe)
    grouped = {*BASIC, *(name for names in _GROUPS.values() for name in names)}
    others = tuple(name for name in known if name not in grouped)
    groups = {"Map": BASIC, **_GROUPS, **({"Other": others} if others else {})}
    return [
        {"title": title, "fields": [field(known[name], basic=name in BASIC) for name in names if name in known]}
        for title, names in groups.items()
    ]


def kinds() -> list[Kind]:
    """Return all kinds of obstacles with their own parameters, levels and softness first, and parameters of places."""
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
