"""Recipe <-> the content of a recipe file; and its JSON Schema.

A file has the words of `Recipe`, and `version` (of this format), `generator` (the program that wrote it), `$schema`
(for editors) and, if any kind of obstacle or the robot of `crossable_by` is from another package,
`plugins: {ramp: rsegen-ramps 1.2}`. The recipe.json of a map has `placed` too, where chance put obstacles in it, which
follows from the rest and is not read. A file leaves out what equals the defaults of its format version
(docs/decisions/0013).
"""

from __future__ import annotations

import json
import warnings
from collections.abc import Iterable, Mapping
from dataclasses import MISSING, dataclass, fields
from functools import lru_cache
from typing import Any

from rsegen import __version__
from rsegen.errors import ParameterError, PluginWarning, UnknownName, inside, refuse_unknown, shown
from rsegen.field.crossing import robot_that_crosses
from rsegen.obstacles import KINDS, Obstacle
from rsegen.obstacles.base import row_parameters
from rsegen.params.plugins import Source
from rsegen.params.registry import summary_of_class
from rsegen.params.sorts import Integer, Json, Parameter, Text, parameters, refuse_longer
from rsegen.recipe.building import placed_obstacles
from rsegen.recipe.map_design import without_derived_keys
from rsegen.recipe.recipe import Recipe

_SOURCE = Text(
    r"[^\x00-\x1f]{1,100}", "a package and its version, or a file", "where a kind of obstacle or robot comes from"
)


@dataclass(frozen=True)
class PluginRecord(Parameter):
    """Kinds of obstacles and robots, each with the package and version, or the file, that it comes from."""

    help: str = "package and version, or file, of each kind of obstacle or robot that is not one of rsegen's own"

    def check(self, where: str, value: object) -> Mapping[str, str]:
        """Return the sources by kinds."""
        if not isinstance(value, Mapping) or not all(isinstance(kind, str) for kind in value):
            raise ParameterError(where, f"{shown(value)} is not {self.describe()}")
        return {kind: _SOURCE.check(f"{where}.{kind}", source) for kind, source in value.items()}

    def schema(self) -> dict[str, Json]:
        """Return the schema of an object whose values are texts."""
        return {"type": "object", "additionalProperties": _SOURCE.schema()}

    def describe(self) -> str:
        """Return in a few words what the value should be."""
        return "kinds of obstacles and robots with their packages, as in {ramp: rsegen-ramps 1.2}"


@dataclass(frozen=True)
class PlacedRecord(Parameter):
    """The drawn places of obstacles in the map of the file, which follow from the rest of it."""

    help: str = "where obstacles with random ends lie in the map of this file, in blocks; ignored when it is read"

    def check(self, where: str, value: object) -> object:
        """Return a list of objects."""
        if not isinstance(value, (list, tuple)) or not all(isinstance(row, Mapping) for row in value):
            raise ParameterError(where, f"{shown(value)} is not {self.describe()}")
        return value

    def schema(self) -> dict[str, Json]:
        """Return the schema of a list of objects."""
        return {"type": "array", "items": {"type": "object"}}

    def describe(self) -> str:
        """Return in a few words what the value should be."""
        return "a list of obstacles with their ends in a map, as rsegen writes it"


def needed_plugins(recipe: Recipe) -> dict[str, str]:
    """Return the kinds in a recipe that come from plug-ins, each with its package and version, or file."""
    return {kind: str(source) for kind, source in plugin_sources([recipe]).items()}


def plugin_sources(recipes: Iterable[Recipe]) -> dict[str, Source]:
    """Return the kinds of obstacles, and of robots that cross, that come from plug-ins, each with its plug-in."""
    sources = dict[str, Source | None]()
    for recipe in recipes:
        sources |= {kind: KINDS.source(kind) for kind in {obstacle.kind for obstacle in recipe.obstacles}}
        if isinstance(recipe.crossable_by, str) and (robot := recipe.crosser):
            sources[recipe.crossable_by] = robot.plugin
    return {kind: source for kind, source in sorted(sources.items()) if source}


def plugin_identities(recipes: Iterable[Recipe], robots: Iterable[Source | None] = ()) -> dict[str, Json]:
    """Return what a journal of a long result says of the plug-ins of recipes and robots: nothing if it uses none."""
    sources = [*plugin_sources(recipes).values(), *robots]
    identities: list[Json] = [*sorted({source.identity for source in sources if source})]
    return {"plugins": identities} if identities else {}


def check_plugins(recorded: Mapping[str, str], content: Mapping[str, Any]) -> None:
    """Raise a ParameterError for the first kind in a file whose plug-in is missing; warn of other versions."""
    rows, robot = content.get("obstacles"), content.get("crossable_by")
    kinds = [row.get("kind") for row in rows if isinstance(row, Mapping)] if isinstance(rows, (list, tuple)) else []
    for name, needed in recorded.items():
        if name in kinds:
            sort, origin = "obstacle kind", _origin_of_kind(name)
        elif name == robot:
            sort, origin = "robot", _origin_of_robot(name)
        else:  # recorded, but no longer used: somebody has changed the file
            continue
        if not origin:
            raise ParameterError("", f"the {sort} {name!r} {Source.parse(needed).install_hint}")
        if origin != needed:
            text = f"{name} of {needed} was used to make this, and {origin} is here: maps may differ"
            warnings.warn(text, PluginWarning, stacklevel=2)


_OWN = "rsegen's own"


def _origin_of_kind(name: str) -> str:
    """Return where a kind of obstacle comes from; an empty text if it is not known."""
    return str(KINDS.source(name) or _OWN) if name in KINDS else ""


def _origin_of_robot(name: str) -> str:
    """Return where a robot comes from; an empty text if it is not known."""
    try:
        return str(robot_that_crosses(name, "crossable_by", kind_only=True).plugin or _OWN)
    except UnknownName:
        return ""


FORMAT = 2
SCHEMA_ID = f"urn:rsegen:recipe:{FORMAT}"
_ENVELOPE: dict[str, Parameter] = {
    "version": Integer(FORMAT, FORMAT, help="version of the recipe format"),
    "generator": Text(r"[^\x00-\x1f]{0,100}", "a short text", help="what wrote the file"),
    "plugins": PluginRecord(),
    "placed": PlacedRecord(),
    "$schema": Text(r"[^\x00-\x1f]{0,500}", "the address of a schema", help="for editors"),
}


MOST_OBSTACLES = 200_000
"""Longest list of obstacles in a file: it takes some ten seconds to read."""


def decode(content: object) -> Recipe:
    """Return the recipe of a file's content; ParameterError if it is not one."""
    if not isinstance(content, Mapping):
        raise ParameterError("", f"{shown(content)} is not a recipe; expected keys such as obstacles: and chunk_size:")
    known = [*parameters(Recipe), "obstacles", *_ENVELOPE]
    refuse_unknown("key", content, known)
    for key in _ENVELOPE.keys() & content.keys():
        _ENVELOPE[key].check(key, content[key])
    if "plugins" in content:
        check_plugins(content["plugins"], content)
    values = {key: value for key, value in content.items() if key not in _ENVELOPE}
    values["obstacles"] = decode_obstacles(values.get("obstacles", []))
    return Recipe(**values)


def decode_obstacles(rows: object) -> tuple[Obstacle, ...]:
    """Return the obstacles of a file's list."""
    if not isinstance(rows, (list, tuple)):
        raise ParameterError("obstacles", f"{shown(rows)} is not a list; start every obstacle with '- kind: '")
    refuse_longer("obstacles", rows, MOST_OBSTACLES)
    obstacles = []
    for index, row in enumerate(rows):
        with inside(f"obstacles[{index}]"):
            if not isinstance(row, Mapping):
                raise ParameterError("", f"{shown(row)} is not an obstacle; expected kind: and its parameters")
            obstacles.append(decode_obstacle(row))
    return tuple(obstacles)


def decode_obstacle(row: Mapping[str, Any]) -> Obstacle:
    """Return the obstacle of one row: `{"kind": "peak", "levels": 5, "first": [2, 2], "last": [7, 7]}`."""
    if "kind" not in row:
        raise ParameterError("kind", f"missing; choose a kind of obstacle (known: {', '.join(KINDS)})")
    cls = KINDS.named(row["kind"], "kind")
    values = {name: value for name, value in row.items() if name != "kind"}
    known = row_parameters(cls)
    refuse_unknown(f"parameter of {cls.kind}", values, known)
    for name in required_parameters(cls):
        if name not in values:
            raise ParameterError(name, f"missing; expected {known[name].describe()} ({known[name].help})")
    return cls(**values)


def row_text(obstacle: Obstacle) -> str:
    """Return an obstacle as `--obstacle` takes it: `peak levels=5 first=2,2 last=7,7`."""
    known = row_parameters(type(obstacle))
    values = [f"{name}={known[name].format(value)}" for name, value in obstacle.entry().items() if name in known]
    return " ".join([obstacle.kind, *values])


def required_parameters(cls: type[Obstacle]) -> tuple[str, ...]:
    """Return the parameters of a kind that have no default; every row must give them."""
    without = {field.name for field in fields(cls) if field.default is field.default_factory is MISSING}
    return tuple(name for name in row_parameters(cls) if name in without)


def encode(recipe: Recipe, *, derived_keys: bool = True) -> dict[str, Json]:
    """Return the content of a recipe's file, with the seed and the generator's version.

    derived_keys: also the keys that obstacles have for their content; files for people have those alone that were given
    """
    needed = needed_plugins(recipe)
    plugins = {"plugins": needed} if needed else {}
    content = {"version": FORMAT, "generator": f"rsegen {__version__}"} | plugins | recipe.entry()
    if not derived_keys and recipe.obstacles:
        content["obstacles"] = [obstacle.entry() for obstacle in without_derived_keys(recipe.obstacles)]
    return content


def to_json(recipe: Recipe, *, derived_keys: bool = True) -> str:
    """Return a recipe as the text of a JSON file, with one line per obstacle; derived_keys: as in `encode`."""
    content = encode(recipe, derived_keys=derived_keys)
    rows = [f"    {json.dumps(row)}" for row in content.pop("obstacles")]
    lines = [f"  {json.dumps(key)}: {json.dumps(value)}" for key, value in content.items()]
    obstacles = "[\n" + ",\n".join(rows) + "\n  ]" if rows else "[]"
    return "{\n" + ",\n".join([*lines, f'  "obstacles": {obstacles}']) + "\n}\n"


def map_json(recipe: Recipe, index: int) -> bytes:
    """Return the JSON file of map `index` of a recipe and no other, with the places that chance gave in it."""
    before, after = _around_index(recipe)
    text = before + (b'\n  "first_map": %d,' % index if index else b"") + after
    rows = [f"    {json.dumps(place)}" for place in placed_obstacles(recipe, index, only_by_chance=True)]
    if not rows:
        return text
    return text.removesuffix(b"\n}\n") + (',\n  "placed": [\n' + ",\n".join(rows) + "\n  ]\n}\n").encode()


@lru_cache(maxsize=8)
def _around_index(recipe: Recipe) -> tuple[bytes, bytes]:
    """Return the parts of a map's JSON file before and after its index: all maps of a recipe have the same ones."""
    before, _, after = to_json(recipe.alone(1)).encode().partition(b'\n  "first_map": 1,')
    return before, after


def schema() -> dict[str, Json]:
    """Return the JSON Schema (2020-12) of a recipe file."""
    properties = {name: _property(parameter) for name, parameter in {**_ENVELOPE, **parameters(Recipe)}.items()}
    rows = {"type": "array", "items": {"oneOf": [_row_schema(cls) for cls in KINDS.values()]}}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$id": SCHEMA_ID,
        "title": "rsegen recipe",
        "description": summary_of_class(Recipe),
        "type": "object",
        "properties": properties | {"obstacles": rows},
        "additionalProperties": False,
    }


def _row_schema(cls: type[Obstacle]) -> dict[str, Json]:
    own = {name: _property(parameter) for name, parameter in row_parameters(cls).items()}
    return {
        "title": cls.kind,
        "description": summary_of_class(cls),
        "type": "object",
        "properties": {"kind": {"const": cls.kind}} | own,
        "required": ["kind", *required_parameters(cls)],
        "additionalProperties": False,
    }


def _property(parameter: Parameter) -> dict[str, Json]:
    return {"description": parameter.help} | parameter.schema()
