"""The difficulty of the maps of a recipe: one for all, or a range, drawn for each map or in even steps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from rsegen.errors import ParameterError, shown
from rsegen.params.sorts import Float, Integer, Json
from rsegen.params.streams import generator

Difficulty = float | tuple[float, float] | tuple[float, float, int]
"""One number; or the least and the most, and, if it is not to be drawn, the number of steps from one to the other."""

_SHARE, _STEPS = Float(0, 1), Integer(2, 1_000_000)

_KEY = "drawn difficulty"
"""Key of its random generator; no key of an obstacle has blanks."""


@dataclass(frozen=True)
class DifficultySort:
    """A difficulty: `0.5`, `[0, 1]` or `[0, 1, 10]`."""

    help: str = ""

    def check(self, where: str, value: object) -> Difficulty:
        if not isinstance(value, (list, tuple)):
            return _SHARE.check(where, value)
        if len(value) not in (2, 3):
            raise ParameterError(where, f"{shown(value)} is not {self.describe()}")
        low, high = (_SHARE.check(f"{where}[{place}]", one) for place, one in enumerate(value[:2]))
        if low > high:
            raise ParameterError(where, f"{shown(value)} begins above its end; give the least first")
        return (low, high) if len(value) == 2 else (low, high, _STEPS.check(f"{where}[2]", value[2]))

    def parse(self, text: str) -> object:
        parts = text.split(",")
        if len(parts) == 1:
            return _SHARE.parse(text)
        return [_SHARE.parse(part) for part in parts[:2]] + [_STEPS.parse(part) for part in parts[2:]]

    def format(self, value: Any) -> str:
        return ",".join(map(_SHARE.format, value)) if isinstance(value, (list, tuple)) else _SHARE.format(value)

    def schema(self) -> dict[str, Json]:
        one, steps = _SHARE.schema(), _STEPS.schema()
        pair = {"type": "array", "items": one, "minItems": 2, "maxItems": 2}
        stepped = {"type": "array", "prefixItems": [one, one, steps], "minItems": 3, "maxItems": 3}
        return {"anyOf": [one, pair, stepped]}

    def describe(self) -> str:
        return "a number from 0 to 1, or a range as in [0.2, 1] or, in 10 steps, [0.2, 1, 10]"


def difficulty_of_map(given: Difficulty, seed: int, index: int) -> float:
    """That of map `index`: of a range drawn evenly, by the seed, or in turn if it has steps."""
    if not isinstance(given, tuple):
        return given
    low, high, *steps = given
    share = index % steps[0] / (steps[0] - 1) if steps else generator(seed, index, _KEY).random()
    return round(low + (high - low) * share, 9)
