"""What follows a name in a flag such as --obstacle 'peak levels=5' or --to 'mjcf shape=hfield': KEY=VALUE."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from rsegen.errors import ParameterError, shown
from rsegen.params.sorts import Parameter


def key_values(words: Iterable[str], known: Mapping[str, Parameter]) -> dict[str, object]:
    """The values by key, each as its parameter reads it; not yet checked, and neither are the keys."""
    found: dict[str, object] = {}
    for word in words:
        key, equals, value = word.partition("=")
        if not equals:
            raise ParameterError("", f"{shown(word)} is not KEY=VALUE")
        if key in found:
            raise ParameterError(key, "is given twice")
        found[key] = known[key].parse(value) if key in known else value
    return found
