"""Every parameter is checked wherever it is given; and each sort of value, thoroughly, as a person gives it.

What a parameter refuses by itself is in tests/params/test_sorts.py; here are file, flag and Python around it.
"""

from __future__ import annotations

import json
import re
from typing import Any

import pytest

from rsegen import KINDS, Recipe
from rsegen.errors import ParameterError
from rsegen.params.sorts import parameters
from tests.support.complaints import (
    Refused,
    recipe,
)
from tests.support.wrong_values import EVERY, OWNERS, SORTS, right, wrong_texts, wrong_values

SORT = pytest.mark.parametrize(("owner", "name"), SORTS.values(), ids=[".".join(one) for one in SORTS.values()])


def in_a_file(refused: Refused, owner: str, name: str, value: object) -> str:
    """The complaint, after the name of the file, that a value in a recipe file gets."""
    row = {"kind": owner, "levels": 5, name: value}
    content = {name: value} if owner == "recipe" else {"obstacles": [{"kind": "peak", "levels": 2}, row]}
    line = refused("generate", recipe(json.dumps(content), "recipe.json"), "-o", "out")
    start = "rsegen: recipe.json: " + ("" if owner == "recipe" else "obstacles[1].")
    assert line.startswith(start)
    return line.removeprefix(start)


def as_a_flag(refused: Refused, owner: str, name: str, text: str) -> str:
    """The complaint that a value on the command line gets, after the flag of an obstacle, or by the name of its own."""
    if owner == "recipe":
        flag = f"--{name.replace('_', '-')}"
        line = refused("generate", f"{flag}={text}", "-o", "out")
        assert line.startswith(f"rsegen: {flag}")
        return name + line.removeprefix(f"rsegen: {flag}")
    given = "" if name == "levels" else "levels=5 "
    line = refused("generate", "--obstacle", f"{owner} {given}'{name}={text}'", "-o", "out")
    return re.sub(rf"^rsegen: --obstacle .*: (?={name}\b)", "", line)


def in_python(owner: str, name: str, value: Any) -> str:
    """The complaint that a value in Python gets."""
    given: dict[str, Any] = {"levels": 5} if owner in KINDS else {}
    with pytest.raises(ParameterError) as caught:
        OWNERS[owner](**given | {name: value})
    return str(caught.value)


def a_wrong_text(owner: str, name: str) -> str:
    texts = list(wrong_texts(name, EVERY[owner, name]))
    return "-1,-1" if "-1,-1" in texts else texts[1]


@pytest.mark.parametrize(("owner", "name"), EVERY, ids=[".".join(one) for one in EVERY])
def test_a_parameter_is_checked_in_a_file_as_a_flag_and_in_python(refused: Refused, owner: str, name: str) -> None:
    wrong = {"a": [1]}
    said = [
        in_a_file(refused, owner, name, wrong),
        as_a_flag(refused, owner, name, a_wrong_text(owner, name)),
        in_python(owner, name, wrong),
    ]
    assert [line for line in said if not re.match(rf"{name}(\[\d\])*: ", line)] == []
    assert [line for line in said if right(EVERY[owner, name]) not in line] == []
    assert said[0] == said[2]


@SORT
def test_a_sort_of_value_in_a_file(refused: Refused, owner: str, name: str) -> None:
    said = {ascii(value): in_a_file(refused, owner, name, value) for value in wrong_values(name, EVERY[owner, name])}
    wrong = {value: line for value, line in said.items() if not re.match(rf"{name}(\[\d\])*: ", line)}
    assert wrong == {}


@SORT
def test_a_sort_of_value_as_a_flag(refused: Refused, owner: str, name: str) -> None:
    said = {text: as_a_flag(refused, owner, name, text) for text in wrong_texts(name, EVERY[owner, name])}
    wrong = {text: line for text, line in said.items() if not re.match(rf"{name}(\[\d\])*: ", line)}
    assert wrong == {}


@pytest.mark.parametrize("name", [name for name in parameters(Recipe) if getattr(Recipe(seed=0), name) is not None])
def test_a_key_with_nothing_after_it(refused: Refused, name: str) -> None:
    line = refused("info", recipe(f"{name}:\n"))
    assert re.match(f"rsegen: recipe.yaml: {name}: an empty value", line)
    assert right(parameters(Recipe)[name]) in line
