"""Where an obstacle lies: cells of the map, of which each coordinate is a number or random."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Literal

from rsegen.errors import ParameterError, shown
from rsegen.params.sorts import Json, as_int, parse_int

Cell = tuple[int, int]
"""x and y in block cells of the whole map, frames left out."""

Coordinate = int | Literal["random"]
Place = tuple[Coordinate, Coordinate]
"""A cell of which a coordinate may be "random": it is then drawn for each map anew."""

ANYWHERE: Place = ("random", "random")


@dataclass(frozen=True)
class CellRef:
    """A place: `[2, 3]`, `[random, 3]`, or `random` for both coordinates."""

    help: str = ""

    def check(self, where: str, value: object) -> Place:
        if isinstance(value, str) and value == "random":
            return ANYWHERE
        if not isinstance(value, (list, tuple)) or len(value) != 2:
            raise ParameterError(where, f"{shown(value)} is not a place; give {self.describe()}")
        x, y = (self._coordinate(f"{where}[{axis}]", at) for axis, at in enumerate(value))
        return x, y

    def _coordinate(self, where: str, value: object) -> Coordinate:
        if isinstance(value, str) and value == "random":
            return "random"
        number = as_int(value)
        if number is None or number < 0:
            raise ParameterError(where, f"{shown(value)} is not a coordinate; give a cell from 0 on, or random")
        return number

    def parse(self, text: str) -> object:
        parts = text.split(",")
        return text if len(parts) == 1 else [parse_int(part) for part in parts]

    def format(self, value: Any) -> str:
        return ",".join(map(str, value)) if isinstance(value, list) else str(value)

    def schema(self) -> dict[str, Json]:
        coordinate = {"anyOf": [{"type": "integer", "minimum": 0}, {"const": "random"}]}
        pair = {"type": "array", "items": coordinate, "minItems": 2, "maxItems": 2}
        return {"anyOf": [pair, {"const": "random"}]}

    def describe(self) -> str:
        return "x and y of a block cell, as in [2, 3], [random, 3] or random"


@dataclass(frozen=True)
class Size2D:
    """A whole number for each of x and y, from 1 to a thousand million; one number stands for both."""

    high: ClassVar[int] = 10**9
    help: str = ""

    def check(self, where: str, value: object) -> Cell:
        values = value if isinstance(value, (list, tuple)) else (value, value)
        if len(values) != 2:
            raise ParameterError(where, f"{shown(value)} is not {self.describe()}")
        numbers = [as_int(one) for one in values]
        for number in numbers:
            if number is None or not 1 <= number <= self.high:
                raise ParameterError(where, f"{shown(value)} is not {self.describe()}")
        return numbers[0], numbers[1]  # type: ignore[return-value]  # None was refused above

    def parse(self, text: str) -> object:
        parts = text.replace("x", ",").split(",")
        numbers = [parse_int(part) for part in parts]
        return numbers[0] if len(numbers) == 1 else numbers

    def format(self, value: Any) -> str:
        return "x".join(map(str, value)) if isinstance(value, list) else str(value)

    def schema(self) -> dict[str, Json]:
        number = {"type": "integer", "minimum": 1, "maximum": self.high}
        return {"anyOf": [number, {"type": "array", "items": number, "minItems": 2, "maxItems": 2}]}

    def describe(self) -> str:
        return f"a whole number in 1..{self.high}, or one for each of x and y, as in [2, 3]"
