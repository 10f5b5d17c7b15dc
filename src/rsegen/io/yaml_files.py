"""Parses YAML that may come from anybody: the work is bounded by the length of the text."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from rsegen.errors import FileError, shown


def parse_yaml(text: str, path: Path) -> object:
    """The content of a YAML text; a FileError for all that rsegen's own files do not have."""
    from rsegen.io.yaml_loader import Loader

    try:
        return Loader(text, path).get_single_data()
    except FileError:
        raise
    except Exception as error:  # PyYAML fails in many ways at values that are not what their tags say
        mark = getattr(error, "problem_mark", None)
        at = f":{mark.line + 1}:{mark.column + 1}" if mark else ""
        raise FileError(f"{path}{at}: not YAML: {parser_message(error)}") from None


def refuse_duplicates(keys: Iterable[tuple[str, str]]) -> None:
    """Raise a FileError for the first duplicate key; each comes with its place in the file."""
    seen = set()
    for key, where in keys:
        if key in seen:
            raise FileError(f"{where}: the key {shown(key)} is given twice")
        seen.add(key)


def parser_message(error: Exception) -> str:
    """The message of a parser, short and without its advice to programmers."""
    if isinstance(error, RecursionError):
        return "nested too deeply"
    if isinstance(error, (AttributeError, LookupError, TypeError)):
        return "a value is not what its tag says"
    return str(getattr(error, "problem", error)).partition(";")[0].partition("\n")[0]
