"""Recipe <-> the content of a recipe file; and its JSON Schema.

A file has the words of `Recipe`, and `version` (of this format), `generator` (what wrote it), `plugins` (kinds of
obstacles from other packages), `$schema` (for editors). It says what differs from the defaults of its format version
(docs/decisions/0013).

Which plug-ins a recipe needs: `plugins: {ramp: rsegen-ramps 1.2}` in its file, where there are any.
"""

from __future__ import annotations

import json
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from rsegen import __version__
from rsegen.errors import ParameterError, PluginWarning, refuse_unknown, shown
from rsegen.field.obstacles import KINDS, Obstacle, kind
from rsegen.params.plugins import Source
from rsegen.params.registry import summary
from rsegen.params.sorts import Integer, Json, Parameter, Text, parameters, refuse_longer
from rsegen.recipe.recipe import Placement, Recipe

_SOURCE = Text(r"[^\x00-\x1f]{1,100}", "a package and its version, or a file", "where a kind of obstacle comes from")


@dataclass(frozen=True)
class PluginRecord:
    """Kinds of obstacles, each with the package and version, or the file, that it comes from."""

    help: str = "package and version, or file, of each kind of obstacle that is not one of rsegen's own"

    def check(self, where: str, value: object) -> Mapping[str, str]:
        """The sources by kinds."""
        if not isinstance(value, Mapping) or not all(isinstance(kind, str) for kind in value):
            raise ParameterError(where, f"{shown(value)} is not {self.describe()}")
        return {kind: _SOURCE.check(f"{where}.{kind}", source) for kind, source in value.items()}

    def parse(self, text: str) -> object:
        """It has no flag."""
        return text

    def format(self, value: Any) -> str:
        """It has no flag."""
        return str(value)

    def schema(self) -> dict[str, Json]:
        """Texts by names."""
        return {"type": "object", "additionalProperties": _SOURCE.schema()}

    def describe(self) -> str:
        """What it should be, in a few words."""
        return "kinds of obstacles with their packages, as in {ramp: rsegen-ramps 1.2}"


def needed_plugins(recipe: Recipe) -> dict[str, str]:
    """The kinds of a recipe's obstacles that come from plug-ins, each with its package and version, or file."""
    kinds = sorted({placement.obstacle.kind for placement in recipe.obstacles})
    sources = {kind: KINDS.source(kind) for kind in kinds}
    return {kind: str(source) for kind, source in sources.items() if source}


def check_plugins(recorded: Mapping[str, str], rows: object) -> None:
    """Raise a ParameterError for the first kind in a file's rows whose plug-in is missing; warn of other versions."""
    kinds = [row.get("kind") for row in rows if isinstance(row, Mapping)] if isinstance(rows, (list, tuple)) else []
    used = {name for name in kinds if isinstance(name, str)}
    for name in (name for name in recorded if name in used):
        if name not in KINDS:
            raise ParameterError("", f"the obstacle kind {name!r} {Source.parse(recorded[name]).remedy}")
        source = str(KINDS.source(name) or "rsegen's own")
        if source != recorded[name]:
            text = f"{name} of {recorded[name]} was used to make this, and {source} is here: maps may differ"
            warnings.warn(text, PluginWarning, stacklevel=2)


FORMAT = 2
SCHEMA_ID = f"urn:rsegen:recipe:{FORMAT}"
_ENVELOPE: dict[str, Parameter] = {
    "version": Integer(FORMAT, FORMAT, help="version of the recipe format"),
    "generator": Text(r"[^\x00-\x1f]{0,100}", "a short text", help="what wrote the file"),
    "plugins": PluginRecord(),
    "$schema": Text(r"[^\x00-\x1f]{0,500}", "the address of a schema", help="for editors"),
}


MOST_OBSTACLES = 200_000
"""In a file: some ten seconds to read."""

OTHER_NAMES = {"levels": "max_height"}
"""Parameters of obstacles that have a second name in files and flags."""


def decode(content: object) -> Recipe:
    """The recipe that a file's content stands for."""
    if not isinstance(content, Mapping):
        raise ParameterError("", f"{shown(content)} is not a recipe; give keys such as obstacles: and chunk_size:")
    known = [*parameters(Recipe), "obstacles", *_ENVELOPE]
    refuse_unknown("key", content, known)
    for key in _ENVELOPE.keys() & content.keys():
        _ENVELOPE[key].check(key, content[key])
    check_plugins(content.get("plugins", {}), content.get("obstacles"))
    values = {key: value for key, value in content.items() if key not in _ENVELOPE}
    values["obstacles"] = decode_placements(values.get("obstacles", []))
    return Recipe(**values)


def decode_placements(entries: object) -> tuple[Placement, ...]:
    """The placements of a file's list of obstacles."""
    if not isinstance(entries, (list, tuple)):
        raise ParameterError("obstacles", f"{shown(entries)} is not a list; start every obstacle with '- kind: '")
    refuse_longer("obstacles", entries, MOST_OBSTACLES)
    return tuple(_placement(f"obstacles[{number}]", entry) for number, entry in enumerate(entries))


def _placement(where: str, entry: object) -> Placement:
    if not isinstance(entry, Mapping):
        raise ParameterError(where, f"{shown(entry)} is not an obstacle; give kind: and its parameters")
    try:
        return decode_placement(entry)
    except ParameterError as error:
        raise error.inside(where) from None


def decode_placement(entry: Mapping[str, Any]) -> Placement:
    """The placement of one row: `{"kind": "peak", "max_height": 5, "first": [2, 2], "last": [7, 7]}`."""
    if "kind" not in entry:
        raise ParameterError("kind", f"is missing (known: {', '.join(KINDS)})")
    cls = kind(entry["kind"])
    own, common = parameters(cls), parameters(Placement)
    given = _by_first_names({key: value for key, value in entry.items() if key != "kind"}, own)
    refuse_unknown(f"parameter of {cls.kind}", given, [*own, *common, *OTHER_NAMES])
    if "max_height" not in given:
        raise ParameterError("levels", f"is missing; give {own['max_height'].describe()}")
    obstacle = cls(**{key: value for key, value in given.items() if key in own})
    return Placement(obstacle=obstacle, **{key: value for key, value in given.items() if key in common})


def _by_first_names(given: Mapping[str, Any], own: Mapping[str, Parameter]) -> dict[str, Any]:
    """What is given under the second name of a parameter, under its first one; checked, so an error says the second."""
    found = dict(given)
    for other, name in OTHER_NAMES.items():
        if other in given and other not in own:
            if name in given:
                raise ParameterError(other, f"is another name of {name}; give one of the two")
            found[name] = own[name].check(other, found.pop(other))
    return found


def encode(recipe: Recipe) -> dict[str, Json]:
    """The content of a recipe's file, with the seed and the generator's version."""
    found = needed_plugins(recipe)
    plugins = {"plugins": found} if found else {}
    return {"version": FORMAT, "generator": f"rsegen {__version__}"} | plugins | recipe.entry()


def to_json(recipe: Recipe) -> str:
    """The recipe as the text of a JSON file, with one line per obstacle."""
    return _json_text(encode(recipe))


def _json_text(content: dict[str, Json]) -> str:
    rows = [f"    {json.dumps(row)}" for row in content.pop("obstacles")]
    lines = [f"  {json.dumps(key)}: {json.dumps(value)}" for key, value in content.items()]
    obstacles = "[\n" + ",\n".join(rows) + "\n  ]" if rows else "[]"
    return "{\n" + ",\n".join([*lines, f'  "obstacles": {obstacles}']) + "\n}\n"


def map_json(recipe: Recipe, index: int) -> bytes:
    """The JSON file of map `index` of a recipe and no other."""
    before, after = _around_index(recipe)
    return before + (b'\n  "first_map": %d,' % index if index else b"") + after


@lru_cache(maxsize=8)
def _around_index(recipe: Recipe) -> tuple[bytes, bytes]:
    """The JSON files of all maps of a recipe are one text, but for the index: what stands before it, and after it."""
    before, _, after = to_json(recipe.alone(1)).encode().partition(b'\n  "first_map": 1,')
    return before, after


def schema() -> dict[str, Json]:
    """The JSON Schema (2020-12) of a recipe file."""
    properties = {name: _property(parameter) for name, parameter in {**_ENVELOPE, **parameters(Recipe)}.items()}
    rows = {"type": "array", "items": {"oneOf": [_row_schema(cls) for cls in KINDS.values()]}}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$id": SCHEMA_ID,
        "title": "rsegen recipe",
        "description": (Recipe.__doc__ or "").strip(),
        "type": "object",
        "properties": properties | {"obstacles": rows},
        "additionalProperties": False,
    }


def _row_schema(cls: type[Obstacle]) -> dict[str, Json]:
    sorts = {**parameters(cls), **parameters(Placement)}
    sorts |= {other: sorts[name] for other, name in OTHER_NAMES.items() if other not in sorts}
    own = {name: _property(parameter) for name, parameter in sorts.items()}
    return {
        "title": cls.kind,
        "description": summary(cls),
        "type": "object",
        "properties": {"kind": {"const": cls.kind}} | own,
        "required": ["kind"],
        "oneOf": [{"required": [name]} for name in ("max_height", *OTHER_NAMES)],
        "additionalProperties": False,
    }


def _property(parameter: Parameter) -> dict[str, Json]:
    return {"description": parameter.help} | parameter.schema()
