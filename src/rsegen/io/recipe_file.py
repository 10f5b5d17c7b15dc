"""Reads and writes recipe files: JSON if the name ends in .json, else YAML. Nothing in them is trusted."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from rsegen.errors import FileError, ParameterError, shown
from rsegen.io.text_files import text_of
from rsegen.io.writer import write_file
from rsegen.params.sorts import Json
from rsegen.recipe.codec import decode, encode, to_json
from rsegen.recipe.recipe import Recipe

MAX_MIB = {".json": 64, ".yaml": 4}
"""The largest files that are read: a minute's work for PyYAML, a second's for JSON."""


def load(path: str | Path) -> Recipe:
    """The recipe in a YAML or JSON file; FileError if it cannot be read, ParameterError if a value is wrong."""
    path = Path(path)
    try:
        return decode(content(path))
    except ParameterError as error:
        raise error.of(str(path)) from None


def content(path: Path) -> object:
    """The content of a YAML or JSON file as plain values; FileError if it cannot be read."""
    most = MAX_MIB.get(path.suffix.lower(), MAX_MIB[".yaml"])
    text = text_of(path, most, f"a recipe (JSON: up to {MAX_MIB['.json']} MiB)")
    return _parse_json(text, path) if path.suffix.lower() == ".json" else _parse_yaml(text, path)


def save(recipe: Recipe, path: str | Path, *, force: bool = False) -> None:
    """Write a recipe file, whole or not at all; an OutputError if it exists already, unless `force`."""
    path = Path(path)
    text = to_json(recipe) if path.suffix.lower() == ".json" else to_yaml(recipe)
    write_file([text.encode()], path, force=force)


def to_yaml(recipe: Recipe) -> str:
    """The recipe as the text of a YAML file."""
    import yaml

    text: str = yaml.safe_dump(encode(recipe), sort_keys=False, default_flow_style=None, allow_unicode=True, width=120)
    return text


def _parse_json(text: str, path: Path) -> object:
    def unique(pairs: list[tuple[str, Json]]) -> dict[str, Json]:
        _refuse_duplicates((key, str(path)) for key, _ in pairs)
        return dict(pairs)

    try:
        return json.loads(text, object_pairs_hook=unique)
    except json.JSONDecodeError as error:
        raise FileError(f"{path}:{error.lineno}:{error.colno}: not JSON: {error.msg}") from None
    except (RecursionError, ValueError) as error:
        raise FileError(f"{path}: not a recipe: {_parser_message(error)}") from None


def _parse_yaml(text: str, path: Path) -> object:
    import yaml

    class Loader(yaml.SafeLoader):
        """Refuses duplicate keys, which PyYAML accepts, and merge keys, which can grow without end."""

        def compose_mapping_node(self, anchor: Any) -> Any:
            node = super().compose_mapping_node(anchor)
            keys = [key for key, _ in node.value if isinstance(key, yaml.ScalarNode)]
            _refuse_duplicates((key.value, f"{path}:{key.start_mark.line + 1}") for key in keys)
            return node

        def flatten_mapping(self, node: Any) -> None:
            for key in (key for key, _ in node.value if key.tag == "tag:yaml.org,2002:merge"):
                raise FileError(
                    f"{path}:{key.start_mark.line + 1}: merge keys ('<<') are not supported; write the keys out"
                )

    try:
        return yaml.load(text, Loader)  # noqa: S506  # a SafeLoader
    except FileError:
        raise
    except Exception as error:  # PyYAML fails in many ways at values that are not what their tags say
        mark = getattr(error, "problem_mark", None)
        at = f":{mark.line + 1}:{mark.column + 1}" if mark else ""
        raise FileError(f"{path}{at}: not YAML: {_parser_message(error)}") from None


def _refuse_duplicates(keys: Iterable[tuple[str, str]]) -> None:
    """Raise a FileError for the first duplicate key; each comes with its place in the file."""
    seen = set()
    for key, where in keys:
        if key in seen:
            raise FileError(f"{where}: the key {shown(key)} is given twice")
        seen.add(key)


def _parser_message(error: Exception) -> str:
    """The message of a parser, short and without its advice to programmers."""
    if isinstance(error, RecursionError):
        return "nested too deeply"
    if isinstance(error, (AttributeError, LookupError, TypeError)):
        return "a value is not what its tag says"
    return str(getattr(error, "problem", error)).partition(";")[0].partition("\n")[0]
