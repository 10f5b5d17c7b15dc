"""Values that no parameter of a sort takes: values as a file or Python gives them, and texts as a flag gives them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from rsegen import KINDS, Recipe
from rsegen.obstacles.base import PLACING, own_parameters
from rsegen.params.sorts import CellRef, Choice, Flag, Float, Integer, ListOf, Parameter, Size2D, Text, parameters
from rsegen.recipe.map_design import CrossableBySort, DifficultySort
from tests.support.complaints import MANY_DIGITS, NO_WORD

OWNERS: Mapping[str, type] = {"recipe": Recipe, **KINDS}
"""Every class that has parameters of a recipe, by name."""
EVERY = {
    **{("recipe", name): parameter for name, parameter in parameters(Recipe).items()},
    **{("peak", name): parameter for name, parameter in PLACING.items()},
    **{(kind, name): parameter for kind, cls in KINDS.items() for name, parameter in own_parameters(cls).items()},
}
"""(owner, name) -> every parameter of a recipe file; those that place any obstacle once, as of a peak."""


def _sort(parameter: Parameter) -> tuple[object, ...]:
    """Key by which its checks differ from those of others, bounds and words aside."""
    return type(parameter), getattr(parameter, "high", 0) is None, getattr(parameter, "length", None)


OR_A_FILE = "inventory"
"""The parameter whose flag takes the name of a file too: for some texts there is no such file."""
SORTS = {_sort(found): (owner, name) for (owner, name), found in reversed(EVERY.items()) if name != OR_A_FILE}
"""Each sort once: (owner, name) of its first parameter."""


def wrong_values(name: str, parameter: Parameter) -> Iterator[object]:
    """Values of a file that no parameter of this sort takes."""
    yield from (value for value in _wrong_values(parameter) if not _takes_words(name, parameter, value))


def wrong_texts(name: str, parameter: Parameter) -> Iterator[str]:
    """Texts of a flag that no parameter of this sort takes."""
    yield from (text for text in _wrong_texts(parameter) if not _takes_words(name, parameter, text))


def right(parameter: Parameter) -> str:
    """Words of the message, whichever the value."""
    return parameter.describe() if isinstance(parameter, (Integer, Float, Choice, Text, Size2D)) else ""


def _takes_words(name: str, parameter: Parameter, value: object) -> bool:
    return (name == "description" and value in ("", NO_WORD)) or (name in ("name", "key") and value == NO_WORD)


_OF_A_SORT: Mapping[type, tuple[object, ...]] = {
    Choice: ("", 1, []),
    Text: (1, 2.5, "x\n", "\n", "\0", "\ud800", "x" * 501),
    CellRef: (1, 1.5, [], [1], [1, 2, 3], [0, -1], [0, 0.5], [0, True], [0, None], [0, "1"], "random,random"),
    Size2D: (0, -1, 1.5, 10**9 + 1, MANY_DIGITS, "2", "2x2", [], [1], [1, 2, 3], [1, 0], [1, True]),
    ListOf: (-1, [], [[1]], [0, None], [0, NO_WORD], [-0.5], [1001.5]),
    CrossableBySort: ("buger", "", 5, [], [5], [5, 5], [5, 5, -1], [5, 5, 5, 5], [5, 5, math.nan], {"robot": "burger"}),
    DifficultySort: (-0.1, 1.1, "0", [], [0.5], [1, 0], [0, 1, 1], [0, 1, 2.5], [0, 1, 2, 3], [0, None], [0, math.nan]),
}
_OF_OTHERS: tuple[object, ...] = (
    1,
    [],
    "1,2",
    [1, -1],
    [1, math.nan],
    [1, math.inf],
    [1, True],
    [1, "2"],
    [1, None],
    [0] * 5,
)


def _wrong_values(parameter: Parameter) -> Iterator[object]:
    yield from () if isinstance(parameter, Flag) else (True,)
    yield from (NO_WORD, {}, {"a": [1]}, [[[[1]]]], math.nan, math.inf, -math.inf)
    match parameter:
        case Integer(low=low, high=high):
            yield from (low - 1, low + 0.5, str(low), -MANY_DIGITS)
            yield from () if high is None else (high + 1, MANY_DIGITS, 1e300)
        case Float(low=low, high=high):
            yield from (math.nextafter(low, -math.inf), math.nextafter(high, math.inf), str(low), MANY_DIGITS)
        case _:
            yield from _OF_A_SORT.get(type(parameter), _OF_OTHERS)


def _wrong_texts(parameter: Parameter) -> Iterator[str]:
    yield ""
    match parameter:
        case Integer(low=low, high=high):
            yield from (str(low - 1), f"{low}.5", f"{low}.0", "1e3", "nan", "inf", "0x10", "1_0", NO_WORD)
            yield from ("-" + "9" * 9000, *(() if high is None else (str(high + 1), "9" * 9000)))
        case Float(low=low, high=high):
            yield from (str(low - 1), str(high + 1), "nan", "inf", "-inf", "1e400", "-1e400", "1,5", NO_WORD)
        case Choice(values=values):
            yield from (NO_WORD, values[0].upper(), f"{values[0]} ", ",".join(values))
        case Text():
            yield from ("x\n", "a\nb", "\x1b[31m", "\udcff", "x" * 501)
        case Size2D():
            yield from ("0", "-1", "2x0", "2x", "x", "1x2x3", "2.5", "2 x 2", NO_WORD, "9" * 9000, "9" * 9000 + "x1")
        case _:
            yield from (NO_WORD, "1;2", "nan,nan", ",", "-1,-1", "1.5,x")
