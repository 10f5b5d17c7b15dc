"""Which plug-ins a recipe needs: `plugins: {ramp: rsegen-ramps 1.2}` in its file, where there are any."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from rsegen.errors import ParameterError, PluginWarning, shown
from rsegen.field.obstacles import KINDS
from rsegen.params.plugins import Source
from rsegen.params.sorts import Json, Text
from rsegen.recipe.recipe import Recipe

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
    used = {kind for kind in kinds if isinstance(kind, str)}
    for kind in (kind for kind in recorded if kind in used):
        if kind not in KINDS:
            raise ParameterError("", f"the obstacle kind {kind!r} {Source.parse(recorded[kind]).remedy}")
        source = str(KINDS.source(kind) or "rsegen's own")
        if source != recorded[kind]:
            text = f"{kind} of {recorded[kind]} was used to make this, and {source} is here: maps may differ"
            warnings.warn(text, PluginWarning, stacklevel=2)
