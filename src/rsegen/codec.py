"""Recipe <-> YAML and JSON; and the JSON Schema of a recipe file.

A file has the words of `Recipe`, and `version` (of this format), `generator` (what wrote it), `$schema` (for editors).
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rsegen.errors import FileError, ParameterError, UnknownName, shown
from rsegen.obstacles import KINDS, Obstacle, kind
from rsegen.params import Json, Parameter, Text, Whole, parameters
from rsegen.recipe import Placement, Recipe
from rsegen.version import __version__

FORMAT = 1
SCHEMA_ID = "urn:rsegen:recipe:1"
MAX_BYTES = {".json": 64 * 2**20}
MAX_BYTES_YAML = 4 * 2**20
"""YAML takes a minute for so much; JSON a second for sixteen times more."""

_ENVELOPE: dict[str, Parameter] = {
    "version": Whole(FORMAT, FORMAT, help="version of the recipe format"),
    "generator": Text(r"[^\x00-\x1f]{0,100}", "a short text", help="what wrote the file"),
    "$schema": Text(r"[^\x00-\x1f]{0,500}", "the address of a schema", help="for editors"),
}


def load(path: str | Path) -> Recipe:
    """The recipe in a YAML or JSON file; FileError where it cannot be read, ParameterError where a value is wrong."""
    path = Path(path)
    text = _text(path)
    content = _parse_json(text, path) if path.suffix.lower() == ".json" else _parse_yaml(text, path)
    try:
        return decode(content)
    except ParameterError as error:
        raise error.of(str(path)) from None


def save(recipe: Recipe, path: str | Path) -> None:
    """Write a recipe file: JSON where the name ends so, else YAML."""
    path = Path(path)
    try:
        path.write_text(to_json(recipe) if path.suffix.lower() == ".json" else to_yaml(recipe), "utf-8", newline="\n")
    except OSError as error:
        raise FileError(f"{path}: {error.strerror or error}") from None


def decode(content: object) -> Recipe:
    """The recipe that a file's content stands for."""
    if content is None:
        raise ParameterError("", "is empty; give keys such as obstacles: and chunk_size:")
    if not isinstance(content, Mapping):
        raise ParameterError("", f"{shown(content)} is not a recipe; give keys such as obstacles: and chunk_size:")
    known = [*parameters(Recipe), "obstacles", *_ENVELOPE]
    for key in content:
        if key not in known:
            raise UnknownName.among("", "key", key, known)
    _refuse_gaps(content)
    for key in _ENVELOPE.keys() & content.keys():
        _ENVELOPE[key].check(key, content[key])
    values = {key: value for key, value in content.items() if key not in _ENVELOPE}
    values["obstacles"] = decode_placements(values.get("obstacles", []))
    return Recipe(**values)


def decode_placements(entries: object) -> tuple[Placement, ...]:
    """The placements of a file's list of obstacles."""
    if not isinstance(entries, (list, tuple)):
        raise ParameterError("obstacles", f"{shown(entries)} is not a list; start every obstacle with '- kind: '")
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
    _refuse_gaps(entry)
    cls = kind(entry["kind"])
    own, common = parameters(cls), parameters(Placement)
    given = {key: value for key, value in entry.items() if key != "kind"}
    for key in given:
        if key not in own and key not in common:
            raise UnknownName.among("", f"parameter of {cls.kind}", key, [*own, *common])
    if "max_height" not in given:
        raise ParameterError("max_height", f"is missing; give {own['max_height'].describe()}")
    obstacle = cls(**{key: value for key, value in given.items() if key in own})
    return Placement(obstacle=obstacle, **{key: value for key, value in given.items() if key in common})


def _refuse_gaps(content: Mapping[str, Json]) -> None:
    """`boundary: null`, or a key with nothing after it, would be easily misread: as none, as 0, as the default."""
    for key, value in content.items():
        if value is None:
            raise ParameterError(key, "has no value; give one, or leave the key out")


def encode(recipe: Recipe) -> dict[str, Json]:
    """The complete content of a recipe's file, with the seed and the generator's version."""
    return {"version": FORMAT, "generator": f"rsegen {__version__}"} | recipe.entry()


def to_json(recipe: Recipe) -> str:
    """The recipe as the text of a JSON file, an obstacle a line."""
    content = encode(recipe)
    rows = [f"    {json.dumps(row)}" for row in content.pop("obstacles")]
    lines = [f"  {json.dumps(key)}: {json.dumps(value)}" for key, value in content.items()]
    obstacles = "[\n" + ",\n".join(rows) + "\n  ]" if rows else "[]"
    return "{\n" + ",\n".join([*lines, f'  "obstacles": {obstacles}']) + "\n}\n"


def to_yaml(recipe: Recipe) -> str:
    """The recipe as the text of a YAML file."""
    import yaml

    text: str = yaml.safe_dump(encode(recipe), sort_keys=False, default_flow_style=None, allow_unicode=True, width=120)
    return text


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
    own = {name: _property(parameter) for name, parameter in {**parameters(cls), **parameters(Placement)}.items()}
    return {
        "title": cls.kind,
        "description": summary(cls),
        "type": "object",
        "properties": {"kind": {"const": cls.kind}} | own,
        "required": ["kind", "max_height"],
        "additionalProperties": False,
    }


def _property(parameter: Parameter) -> dict[str, Json]:
    return {"description": parameter.help} | parameter.schema()


def summary(cls: type[Obstacle]) -> str:
    """A kind's meaning in one line."""
    return (cls.__doc__ or "").strip().splitlines()[0]


def _text(path: Path) -> str:
    most = MAX_BYTES.get(path.suffix.lower(), MAX_BYTES_YAML)
    try:
        with path.open("rb") as file:
            content = file.read(most + 1)
    except OSError as error:
        raise FileError(f"{path}: {error.strerror or error}") from None
    if len(content) > most:
        raise FileError(f"{path}: larger than {most // 2**20} MiB, too large for a recipe")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise FileError(f"{path}: not a text in UTF-8") from None


def _parse_json(text: str, path: Path) -> object:
    def unique(pairs: list[tuple[str, Json]]) -> dict[str, Json]:
        found: dict[str, Json] = {}
        for key, value in pairs:
            if key in found:
                raise FileError(f"{path}: the key {shown(key)} stands twice")
            found[key] = value
        return found

    try:
        return json.loads(text, object_pairs_hook=unique)
    except json.JSONDecodeError as error:
        raise FileError(f"{path}:{error.lineno}:{error.colno}: not JSON: {error.msg}") from None
    except (RecursionError, ValueError) as error:
        raise FileError(f"{path}: not a recipe: {error}") from None


def _parse_yaml(text: str, path: Path) -> object:
    import yaml

    class Loader(yaml.SafeLoader):
        """Refuses a key that stands twice, which YAML forbids and PyYAML lets pass."""

        def construct_mapping(self, node: Any, deep: bool = False) -> dict[Any, Any]:  # noqa: FBT001, FBT002  # PyYAML's
            keys = [self.construct_object(key, deep=True) for key, _ in node.value]
            for number, key in enumerate(keys):
                if key in keys[:number]:
                    raise FileError(
                        f"{path}:{node.value[number][0].start_mark.line + 1}: the key {shown(key)} stands twice"
                    )
            return super().construct_mapping(node, deep)

    try:
        return yaml.load(text, Loader)  # noqa: S506  # a SafeLoader
    except yaml.MarkedYAMLError as error:
        at = f":{error.problem_mark.line + 1}:{error.problem_mark.column + 1}" if error.problem_mark else ""
        raise FileError(f"{path}{at}: not YAML: {error.problem}") from None
    except (yaml.YAMLError, RecursionError, ValueError) as error:
        raise FileError(f"{path}: not YAML: {str(error).splitlines()[0]}") from None
