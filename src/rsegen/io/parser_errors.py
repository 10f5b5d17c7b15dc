"""What the parsers of JSON and YAML have in common: their messages, and the refusal of duplicate keys."""

from __future__ import annotations

from collections.abc import Iterable

from rsegen.errors import FileError, shown


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
