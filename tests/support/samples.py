"""A valid value for any parameter, other than its default; so tests of all parameters need no list of them."""

from __future__ import annotations

from typing import Any

from rsegen import Recipe
from rsegen.errors import ParameterError
from rsegen.params.sorts import CellRef, Choice, Flag, Float, Integer, ListOf, Parameter, Size2D, Text, parameters
from rsegen.recipe.codec import decode
from rsegen.recipe.map_design import CrossableBySort, DifficultySort

NUMBERS = (12.5, 5, 0.5)
TEXTS = ("course", "#3a0F10")


def sample(parameter: Parameter, default: object) -> Any:
    """A value as a recipe file has it: the first of some candidates that is valid and not the default."""
    return next(value for value in _candidates(parameter) if value != default and _is_valid(parameter, value))


def _candidates(parameter: Parameter) -> list[Any]:
    match parameter:
        case Flag():
            return [True, False]
        case Choice(values=values):
            return list(reversed(values))
        case Integer() | Float() | Text():
            return [*NUMBERS, *TEXTS]
        case DifficultySort() | CrossableBySort():
            return [0.5, [20, 20, 20]]
        case Size2D() | CellRef():
            return [[2, 3]]
        case ListOf(sort=sort, length=length):
            return [[sample(sort, None)] * (length or 2)]
    raise TypeError(f"no sample for {parameter}: add one here")


def _is_valid(parameter: Parameter, value: object) -> bool:
    try:
        parameter.check("", value)
    except ParameterError:
        return False
    return True


def _full() -> Recipe:
    bare = Recipe(seed=1)
    open_ = {name: sort for name, sort in parameters(Recipe).items() if getattr(bare, name) is None}
    return decode({"seed": 1} | {name: sample(sort, None) for name, sort in open_.items()})


FULL = _full()
"""A recipe that gives every parameter whose default is None."""
