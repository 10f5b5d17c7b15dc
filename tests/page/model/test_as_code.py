"""Recipes as a command line and as Python code, which make the same recipes."""

from __future__ import annotations

import shlex
from dataclasses import dataclass

from hypothesis import example, given

from rsegen import Peak, Recipe
from rsegen.cli.command_line import parsed
from rsegen.cli.flags import recipe_from
from rsegen.page.model.texts import command_line, python_code
from tests.support.samples import FULL
from tests.support.strategies import recipes


@given(recipes())
@example(FULL)
def test_the_command_line_makes_the_same_recipe(recipe: Recipe) -> None:
    words = shlex.split(command_line(recipe, "worlds"))
    assert recipe_from(parsed(words[1:])) == recipe


@given(recipes())
@example(FULL)
def test_the_python_code_makes_the_same_recipe(recipe: Recipe) -> None:
    code = python_code(recipe, "worlds").rpartition("rsegen.generate")[0]
    names: dict[str, object] = {}
    exec(code, names)  # noqa: S102  # our own
    assert names["recipe"] == recipe


@dataclass(frozen=True, kw_only=True, slots=True)
class Hill(Peak):
    """A kind of another package."""


def test_the_python_code_imports_kinds_of_other_packages() -> None:
    recipe = Recipe(seed=1, obstacles=[Hill(levels=3), Peak(levels=5)])
    code = python_code(recipe, "worlds").splitlines()
    assert code[:2] == ["import rsegen", f"from {Hill.__module__} import Hill"]
    assert any(line == "        Hill(levels=3)," for line in code)
    assert any(line == "        rsegen.Peak(levels=5)," for line in code)
