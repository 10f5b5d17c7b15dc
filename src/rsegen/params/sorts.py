"""The types of parameters: bounds, unit and help of a field are given once, in its annotation.

    softness: Annotated[float, Float(0, 100, unit="%", help="run-out of the sides")] = 0.0

From there come the check in Python, the flag and the form, and the JSON Schema. A parameter is anything with the
methods of `Parameter`; a value that it accepts is returned in its one canonical form.

Two sorts are for cells of the map: `CellRef`, each of whose coordinates is a number or random, and `Size2D`. On the
command line lengths may have a unit, as in `3.5in`, `8ft`, `38mm` (`with_lengths`).
"""

from __future__ import annotations

import builtins
import math
import operator
import os
import re
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cache
from inspect import get_annotations
from pathlib import Path
from types import MappingProxyType
from typing import Any, ClassVar, Literal, Protocol

from rsegen.errors import ParameterError, PluginError, did_you_mean, shown

Json = Any
"""A value of JSON or YAML: a dict, list, str, int, float, bool or None."""


MOST_LEVELS = 32767
"""Levels of an obstacle, and of an inventory: the heights of blocks are 16-bit integers."""


class Parameter(Protocol):
    """The sort of value that a field takes."""

    @property
    def help(self) -> str: ...
    def check(self, where: str, value: object) -> Any:
        """Return `value` in canonical form, or raise a ParameterError that says what would be right."""

    def parse(self, text: str) -> object:
        """Parse a text of the command line, by default as it stands; the value is not yet checked."""
        return text

    def format(self, value: Any) -> str:
        """Return the text of the command line for a value as a file has it."""
        return str(value)

    def schema(self) -> dict[str, Json]:
        """Return the JSON Schema of the sort."""

    def describe(self) -> str:
        """Describe the values that it takes, in a few words."""


@dataclass(frozen=True)
class Float(Parameter):
    """A finite number from `low` to `high`, both allowed; `usual`: the range that most people need, for sliders."""

    low: float = -math.inf
    high: float = math.inf
    unit: str = ""
    help: str = ""
    usual: tuple[float, float] | None = None

    def check(self, where: str, value: object) -> float:
        try:  # a text has no __float__; an integer of hundreds of digits, and an array, have one that fails
            number = float(value) if hasattr(value, "__float__") and not isinstance(value, bool) else None
        except (OverflowError, TypeError, ValueError):
            number = None
        if number is None:
            raise ParameterError(where, f"{shown(value)} is not a number; expected {self.describe()}")
        if not math.isfinite(number):
            raise ParameterError(where, f"{shown(value)} is not a finite number; expected {self.describe()}")
        if not self.low <= number <= self.high:
            raise ParameterError(where, f"{shown(value)} is outside {self.describe()}")
        return number

    def parse(self, text: str) -> object:
        try:
            return float(text)
        except ValueError:
            return text

    def schema(self) -> dict[str, Json]:
        bounds = {"minimum": self.low, "maximum": self.high}
        return {"type": "number"} | {key: bound for key, bound in bounds.items() if math.isfinite(bound)}

    def describe(self) -> str:
        return _interval(self.low, self.high, self.unit)


@dataclass(frozen=True)
class Integer(Parameter):
    """A whole number from `low` to `high`, both allowed; `usual`: the range that most people need, for sliders."""

    low: int
    high: int | None = None
    unit: str = ""
    help: str = ""
    usual: tuple[int, int] | None = None

    def check(self, where: str, value: object) -> int:
        number = as_int(value)
        if number is None:
            raise ParameterError(where, f"{shown(value)} is not a whole number; expected {self.describe()}")
        if number < self.low or (self.high is not None and number > self.high):
            amiss = "is not" if self.high in (None, self.low) else "is outside"
            raise ParameterError(where, f"{shown(number)} {amiss} {self.describe()}")
        return number

    def parse(self, text: str) -> object:
        return parse_int(text)

    def schema(self) -> dict[str, Json]:
        high = {} if self.high is None else {"maximum": self.high}
        return {"type": "integer", "minimum": self.low} | high

    def describe(self) -> str:
        return _interval(self.low, math.inf if self.high is None else self.high, self.unit)


@dataclass(frozen=True)
class Choice(Parameter):
    """A word from a few."""

    values: tuple[str, ...]
    help: str = ""

    def check(self, where: str, value: object) -> str:
        if isinstance(value, str) and value in self.values:
            return value
        raise ParameterError(where, f"{shown(value)} is not one of {self.describe()}{did_you_mean(value, self.values)}")

    def schema(self) -> dict[str, Json]:
        return {"enum": list(self.values)}

    def describe(self) -> str:
        return ", ".join(self.values)


@dataclass(frozen=True)
class Flag(Parameter):
    """Yes or no."""

    help: str = ""

    def check(self, where: str, value: object) -> bool:
        if isinstance(value, bool):
            return value
        raise ParameterError(where, f"{shown(value)} is neither yes nor no")

    def parse(self, text: str) -> object:
        return {"yes": True, "no": False}.get(text, text)

    def format(self, value: Any) -> str:
        return "yes" if value else "no"

    def schema(self) -> dict[str, Json]:
        return {"type": "boolean"}

    def describe(self) -> str:
        return "yes or no"


@dataclass(frozen=True)
class Text(Parameter):
    """A text that a pattern matches whole, and that UTF-8 can write."""

    pattern: str
    meaning: str
    help: str = ""

    def check(self, where: str, value: object) -> str:
        if isinstance(value, str) and re.fullmatch(self.pattern, value) and not re.search("[\ud800-\udfff]", value):
            return value
        amiss = "an empty value" if value is None else f"invalid value {shown(value)}"
        raise ParameterError(where, f"{amiss}: expected {self.meaning}")

    def schema(self) -> dict[str, Json]:
        return {"type": "string", "pattern": f"^{self.pattern}$"}

    def describe(self) -> str:
        return self.meaning


@dataclass(frozen=True)
class ListOf(Parameter):
    """A list of values of one type, `length` of them or up to `most`; a single value is a list of one."""

    sort: Parameter
    length: int | None = None
    help: str = ""
    most: int = 1_000_000

    def check(self, where: str, value: object) -> tuple[Any, ...]:
        if not isinstance(value, (list, tuple)) and not self.length:
            return (self.sort.check(where, value),)
        if not isinstance(value, (list, tuple)) or len(value) != (self.length or max(len(value), 1)):
            raise ParameterError(where, f"{shown(value)} is not {self.describe()}")
        refuse_longer(where, value, self.most)
        return tuple(self.sort.check(f"{where}[{index}]", entry) for index, entry in enumerate(value))

    def parse(self, text: str) -> object:
        return [self.sort.parse(part) for part in list_parts(text)]

    def format(self, value: Any) -> str:
        return ",".join(map(self.sort.format, value))

    def schema(self) -> dict[str, Json]:
        sort = self.sort.schema()
        if self.length:
            return {"type": "array", "items": sort, "minItems": self.length, "maxItems": self.length}
        several = {"title": "a list", "type": "array", "items": sort, "minItems": 1, "maxItems": self.most}
        return {"anyOf": [{"title": "one value", **sort}, several]}

    def describe(self) -> str:
        sort = self.sort.describe()
        return f"{self.length} values, each {sort}" if self.length else f"{sort}, or a list of these"


@dataclass(frozen=True)
class Reference(Parameter):
    """A name, a path, or the thing itself in Python: whoever is called looks it up.

    meaning: what it may be, in words   types: those that Python may give
    known: returns the known names, for completion and forms; called when they are wanted, as registries load plug-ins
    """

    meaning: str = "a name or a path"
    help: str = ""
    types: tuple[type, ...] = (str,)
    known: Callable[[], Iterable[str]] | None = None

    def check(self, where: str, value: object) -> Any:
        if value is None or (isinstance(value, str) and not value):
            raise ParameterError(where, f"no value; expected {self.meaning}")
        if not isinstance(value, self.types):
            raise ParameterError(where, f"{shown(value)} is not {self.meaning}")
        return value

    def schema(self) -> dict[str, Json]:
        return {"type": "string", "minLength": 1}

    def describe(self) -> str:
        return self.meaning


@dataclass(frozen=True)
class FilePath(Reference):
    """The path of a file or folder, as text or a Path; a Path in canonical form."""

    meaning: str = "a folder"

    def check(self, where: str, value: object) -> Path:
        if not isinstance(value, str | os.PathLike) or not str(value):
            amiss = "no value" if value is None or isinstance(value, str) else f"{shown(value)} is not a path"
            raise ParameterError(where, f"{amiss}; expected {self.meaning}")
        return Path(value)


def refuse_longer(where: str, values: Sequence[object], most: int) -> None:
    """Raise a ParameterError for a list of more than `most` values, before they are looked at."""
    if len(values) > most:
        raise ParameterError(where, f"{len(values):,} values; at most {most:,} are allowed")


def parameters(owner: type) -> Mapping[str, Parameter]:
    """Return the parameters of a dataclass by name, in the order of its fields."""
    return _parameters(owner)


@cache
def _parameters(owner: Any) -> Mapping[str, Parameter]:
    known = hints(owner)
    marked = [field.name for field in fields(owner) if hasattr(known.get(field.name), "__metadata__")]
    return MappingProxyType({name: sort_of(name, known[name]) for name in marked})


def sort_of(name: str, annotation: Any) -> Parameter:
    """Return the sort of a parameter, which is first in its annotated type; PluginError if something else is."""
    sort = annotation.__metadata__[0]
    if isinstance(sort, type) or not callable(getattr(sort, "check", None)):
        example = "Annotated[int, Integer(1, 9, help='number of steps')]"
        problem = f"the parameter {name!r} is annotated with {shown(sort)}, which is no sort of values"
        raise PluginError(f"{problem}; use one of rsegen.params.sorts, as in {example}")
    return sort  # type: ignore[no-any-return]  # it has the methods of one


def hints(owner: Any) -> dict[str, Any]:
    """Return the annotations of a function, or of a class and its bases; a class overrides its bases.

    A name that only type checkers import stands for a class of that name: it has no sort, and is not imported for it.
    """
    known: dict[str, Any] = {}
    for part in reversed(owner.__mro__) if isinstance(owner, type) else [owner]:
        names = _Known({**vars(builtins), **vars(sys.modules[part.__module__])})
        known |= get_annotations(part, locals=names, eval_str=True)
    return known


class _Known(dict[str, Any]):
    def __missing__(self, name: str) -> type:
        return type(name, (), {})


def validate(instance: object) -> None:
    """Check every parameter of a frozen dataclass and store its canonical form; None stays where it is the default."""
    defaults = {field.name: field.default for field in fields(instance)}  # type: ignore[arg-type]  # a dataclass
    for name, parameter in parameters(type(instance)).items():
        value = getattr(instance, name)
        if not (value is None and defaults[name] is None):
            object.__setattr__(instance, name, parameter.check(name, value))


def changed(instance: object) -> dict[str, Json]:
    """Return the parameters of a dataclass that differ from their defaults, as a file has them."""
    defaults = {field.name: field.default for field in fields(instance)}  # type: ignore[arg-type]  # a dataclass
    values = {name: getattr(instance, name) for name in parameters(type(instance))}
    return {name: plain(value) for name, value in values.items() if value != defaults[name]}


def plain(value: object) -> Json:
    """Return a value as a file has it: lists for tuples, and 10 for 10.0."""
    if isinstance(value, tuple):
        return [plain(part) for part in value]
    if isinstance(value, float) and value.is_integer():
        return int(value)
    return value


def as_int(value: object) -> int | None:
    """Return `value` as an int if it is a whole number (2, 2.0, numpy's), else None; also for a bool."""
    if isinstance(value, float):
        return int(value) if value.is_integer() else None
    try:
        return None if isinstance(value, bool) else operator.index(value)  # type: ignore[arg-type]  # asks just that
    except TypeError:
        return None


def list_parts(text: str) -> list[str]:
    """Return the parts of a list as a shell has it, `1,2`, or as the help, Python or a file writes it, `[1, 2]`."""
    inside = re.fullmatch(r"\((.*)\)|\[(.*)\]", text)
    return re.split(r"\s*,\s*", (inside[1] or inside[2] or "").strip()) if inside else text.split(",")


def parse_int(text: str) -> int | str:
    """Return the integer of a text of digits, or the text itself if it is something else."""
    return int(text) if re.fullmatch(r"[+-]?[0-9]{1,4000}", text) else text


def _interval(low: float, high: float, unit: str) -> str:
    tail = f" {unit}" if unit else ""
    if math.isinf(high):
        return f"{_bound(low)} or more{tail}"
    return f"{_bound(low)}{tail}" if low == high else f"{_bound(low)}..{_bound(high)}{tail}"


def _bound(number: float) -> str:
    return str(int(number)) if float(number).is_integer() else str(number)


Cell = tuple[int, int]
"""x and y in block cells of the whole map, frames left out."""

Coordinate = int | Literal["random"]
Place = Sequence[Coordinate]
"""x and y of a cell, of which each may be "random": it is then drawn for each map anew."""

ANYWHERE: Place = ("random", "random")


@dataclass(frozen=True)
class CellRef(Parameter):
    """A place: `[2, 3]`, `[random, 3]`, or `random` for both coordinates."""

    help: str = ""

    def check(self, where: str, value: object) -> Place:
        if isinstance(value, str) and value == "random":
            return ANYWHERE
        if not isinstance(value, (list, tuple)) or len(value) != 2:
            raise ParameterError(where, f"{shown(value)} is not a place; expected {self.describe()}")
        x, y = (self._coordinate(f"{where}[{axis}]", at) for axis, at in enumerate(value))
        return x, y

    def _coordinate(self, where: str, value: object) -> Coordinate:
        if isinstance(value, str) and value == "random":
            return "random"
        cell = as_int(value)
        if cell is None or cell < 0:
            raise ParameterError(where, f"{shown(value)} is not a coordinate; expected a cell from 0 on, or random")
        return cell

    def parse(self, text: str) -> object:
        parts = list_parts(text)
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
class Size2D(Parameter):
    """A whole number for each of x and y, from 1 to a thousand million; one number stands for both."""

    high: ClassVar[int] = 10**9
    help: str = ""

    def check(self, where: str, value: object) -> Cell:
        values = value if isinstance(value, (list, tuple)) else (value, value)
        numbers = [number for entry in values[:2] if (number := as_int(entry)) and 1 <= number <= self.high]
        if len(values) != 2 or len(numbers) != 2:
            raise ParameterError(where, f"{shown(value)} is not {self.describe()}")
        return numbers[0], numbers[1]

    def parse(self, text: str) -> object:
        parts = list_parts(text.replace("x", ","))
        numbers = [parse_int(part) for part in parts]
        return numbers[0] if len(numbers) == 1 else numbers

    def format(self, value: Any) -> str:
        return "x".join(map(str, value)) if isinstance(value, list) else str(value)

    def schema(self) -> dict[str, Json]:
        number = {"type": "integer", "minimum": 1, "maximum": self.high}
        two = {"title": "x and y", "type": "array", "items": number, "minItems": 2, "maxItems": 2}
        return {"anyOf": [{"title": "square", **number}, two]}

    def describe(self) -> str:
        return f"a whole number in 1..{self.high}, or one for each of x and y, as in [2, 3]"


NANOMETRE_DIGITS = 9
"""Decimals to which metres are rounded, so that 3 * 0.1 m and 0.3 m are equal: sums of lengths up to 100 km are exact
to a nanometre in double precision."""
NANOMETRES: int = 10**NANOMETRE_DIGITS
"""Nanometres per metre: heights are compared with limits as whole nanometres."""

CENTIMETRES = {"cm": 1.0, "mm": 0.1, "m": 100.0, "in": 2.54, "ft": 30.48}
"""Centimetres of each unit of length."""

_UNITS = "|".join(sorted(CENTIMETRES, key=len, reverse=True))
_LENGTH = re.compile(rf"\s*([0-9]*\.?[0-9]+)\s*({_UNITS})\s*")
_FRACTION = re.compile(r"\s*(?:([0-9]+)\s+)?([0-9]+)/([1-9][0-9]*)\s*(in|ft)\s*")
_NUMBER = re.compile(r"\s*[-+]?[0-9.]+(e[-+]?[0-9]+)?\s*")


def with_lengths(text: str, parameter: Parameter, where: str, *, units: str | None = None) -> str:
    """Return the text of a parameter with every length as a number of its unit, cm or mm; other parameters as they are.

    units: if that is `in`, a ParameterError for a length without a unit, which could be either.
    """
    sort = parameter.sort if isinstance(parameter, ListOf) else parameter
    if not isinstance(sort, Float) or sort.unit not in ("cm", "mm"):
        return text
    parts = list_parts(text) if isinstance(parameter, ListOf) else [text]
    return ",".join(_number(part, sort.unit, where, units) for part in parts)


def _number(text: str, unit: str, where: str, units: str | None) -> str:
    fraction = _FRACTION.fullmatch(text)
    if fraction:  # rounded to a nanometre in cm, so that 3.5in and 8.89 cm are the same number
        whole, parts, of, own = fraction.groups()
        return repr(round((int(whole or 0) + int(parts) / int(of)) * CENTIMETRES[own] / CENTIMETRES[unit], 7))
    length = _LENGTH.fullmatch(text)
    if length:
        return repr(round(float(length[1]) * CENTIMETRES[length[2]] / CENTIMETRES[unit], 7))
    if units == "in" and _NUMBER.fullmatch(text):
        raise ParameterError(
            where, f"{shown(text)} has no unit; with units in write {text.strip()}in or {text.strip()}{unit}"
        )
    return text


def key_values(words: Iterable[str], known: Mapping[str, Parameter]) -> dict[str, object]:
    """Return the values by key, each as its parameter reads it; not yet checked, and neither are the keys."""
    values: dict[str, object] = {}
    for word in words:
        key, equals, value = word.partition("=")
        if not equals:
            raise ParameterError("", f"{shown(word)} is not KEY=VALUE, written without blanks")
        if key in values:
            raise ParameterError(key, "is given twice")
        values[key] = known[key].parse(value) if key in known else value
    return values
