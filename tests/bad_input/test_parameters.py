"""Every parameter that there is, by the sort of value that it takes."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from rsegen import KINDS, Placement, Recipe
from rsegen.params.places import CellRef, Size2D
from rsegen.params.sorts import Choice, Float, Integer, ListOf, Parameter, Text, parameters
from tests.support.complaints import (
    MANY_DIGITS,
    NO_WORD,
    Refused,
    recipe,
)


def wrong_values(parameter: Parameter) -> Iterator[object]:
    """What a file may give that no parameter of this sort takes."""
    yield from (True, NO_WORD, {}, {"a": [1]}, [[[[1]]]], math.nan, math.inf, -math.inf)
    match parameter:
        case Integer(low=low, high=high):
            yield from (low - 1, low + 0.5, str(low), -MANY_DIGITS)
            yield from () if high is None else (high + 1, MANY_DIGITS, 1e300)
        case Float(low=low, high=high):
            yield from (math.nextafter(low, -math.inf), math.nextafter(high, math.inf), str(low), MANY_DIGITS)
        case Choice():
            yield from ("", 1, [])
        case Text():
            yield from (1, 2.5, "x\n", "\n", "\0", "\ud800", "x" * 501)
        case CellRef():
            yield from (1, 1.5, [], [1], [1, 2, 3], [0, -1], [0, 0.5], [0, True], [0, None], [0, "1"], "random,random")
        case Size2D():
            yield from (0, -1, 1.5, 10**9 + 1, MANY_DIGITS, "2", "2x2", [], [1], [1, 2, 3], [1, 0], [1, True])
        case ListOf():
            yield from (-1, [], [[1]], [0, None], [0, NO_WORD], [-0.5], [1001.5])
        case _:
            yield from (1, [], "1,2", [1, -1], [1, math.nan], [1, math.inf], [1, True], [1, "2"], [1, None], [0] * 5)


def wrong_texts(parameter: Parameter) -> Iterator[str]:
    """What a flag may give that no parameter of this sort takes."""
    yield ""
    match parameter:
        case Integer(low=low, high=high):
            yield from (
                str(low - 1),
                f"{low}.5",
                f"{low}.0",
                "1e3",
                "nan",
                "inf",
                "0x10",
                "1_0",
                NO_WORD,
                "-" + "9" * 9000,
            )
            yield from () if high is None else (str(high + 1), "9" * 9000)
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


def right(parameter: Parameter) -> str:
    """What the complaint must say, whichever the value."""
    return parameter.describe() if isinstance(parameter, (Integer, Float, Choice, Text, Size2D)) else ""


def cases(owner: type, wrong: Callable[[Parameter], Iterator[object]]) -> list[Any]:
    """(name, value) for every parameter of a class."""
    return [
        pytest.param(name, value, id=f"{name}-{ascii(value)[:30]}")
        for name, parameter in parameters(owner).items()
        for value in wrong(parameter)
        if not (name == "description" and value in ("", NO_WORD)) and not (name in ("name", "key") and value == NO_WORD)
    ]


def rows(wrong: Callable[[Parameter], Iterator[object]]) -> list[Any]:
    """(kind, name, value) for every parameter of every kind, and for those of its place."""
    return [
        pytest.param(kind, *case.values, id=f"{kind}-{case.id}")
        for kind, cls in KINDS.items()
        for case in [*cases(cls, wrong), *(cases(Placement, wrong) if kind == "peak" else [])]
    ]


@pytest.mark.parametrize(("name", "value"), cases(Recipe, wrong_values))
def test_a_global_parameter_in_a_file(refused: Refused, name: str, value: object) -> None:
    line = refused("generate", recipe(json.dumps({name: value}), "recipe.json"), "-o", "out")
    assert re.match(rf"rsegen: recipe.json: {name}(\[\d\])?: ", line)
    assert right(parameters(Recipe)[name]) in line


@pytest.mark.parametrize(("name", "text"), cases(Recipe, wrong_texts))
def test_a_global_parameter_as_a_flag(refused: Refused, name: str, text: str) -> None:
    line = refused("generate", f"--{name.replace('_', '-')}={text}", "-o", "out")
    file = f"{text}: No such file" if name == "inventory" else name
    assert re.match(rf"rsegen: ({name}(\[\d\])?: |{re.escape(file)})", line)
    assert right(parameters(Recipe)[name]) in line


@pytest.mark.parametrize("name", [name for name in parameters(Recipe) if getattr(Recipe(seed=0), name) is not None])
def test_a_key_with_nothing_after_it(refused: Refused, name: str) -> None:
    line = refused("info", recipe(f"{name}:\n"))
    assert line.startswith(f"rsegen: recipe.yaml: {name}: nothing ")
    assert right(parameters(Recipe)[name]) in line


@pytest.mark.parametrize(("kind", "name", "value"), rows(wrong_values))
def test_a_parameter_of_an_obstacle_in_a_file(refused: Refused, kind: str, name: str, value: object) -> None:
    content = {"obstacles": [{"kind": "peak", "max_height": 2}, {"kind": kind, "max_height": 5} | {name: value}]}
    line = refused("generate", recipe(json.dumps(content), "recipe.json"), "-o", "out")
    assert line.startswith(f"rsegen: recipe.json: obstacles[1].{name}")
    assert right({**parameters(Placement), **parameters(KINDS[kind])}[name]) in line


@pytest.mark.parametrize(("kind", "name", "text"), rows(wrong_texts))
def test_a_parameter_of_an_obstacle_as_a_flag(refused: Refused, kind: str, name: str, text: str) -> None:
    given = "" if name == "max_height" else "max_height=5 "
    line = refused("generate", "--obstacle", f"{kind} {given}'{name}={text}'", "-o", "out")
    assert f": {name}" in line
    assert right({**parameters(Placement), **parameters(KINDS[kind])}[name]) in line
