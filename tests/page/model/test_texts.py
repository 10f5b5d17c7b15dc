"""Saving changes only what was changed in a file that a person wrote."""

from __future__ import annotations

import json
from dataclasses import replace
from difflib import unified_diff
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rsegen import Peak, Recipe
from rsegen.page.model.texts import text_after
from rsegen.recipe.codec import decode, to_json
from rsegen.recipe.examples import EXAMPLES
from rsegen.recipe.recipe_file import parse_yaml
from tests.support.strategies import recipes

TEXT = """\
# My course, as built in May
version: 2   # of the format
name:   "course"
seed: 7
chunks: [2,1]        # wide
obstacles:
  # the floor
  - {kind: random,   levels: 3}   # rough
  - kind: peak        # the hill
    levels: 5
    first: [ 2, 2 ]
    last: [7, 7]

  # a wall
  - kind: horizontal_barrier
    levels: 4
    first: [3, 0]
    last: [3, 9]
# the end
"""


def recipe_of(text: str) -> Recipe:
    return decode(parse_yaml(text, Path("recipe.yaml")))


RECIPE = recipe_of(TEXT)
FLOOR, HILL, WALL = RECIPE.obstacles


def difference(recipe: Recipe) -> list[str]:
    """The lines that saving takes away and adds, after checking that the file is the recipe."""
    after = text_after(TEXT, recipe, ".yaml")
    assert recipe_of(after) == recipe
    lines = unified_diff(TEXT.splitlines(), after.splitlines(), n=0, lineterm="")
    return [line for line in lines if line[:1] in "+-" and line[:3] not in ("+++", "---")]


def test_nothing_changed_is_nothing_written_anew() -> None:
    assert text_after(TEXT, RECIPE, ".yaml") == TEXT


def test_a_parameter_is_changed_in_its_line_and_a_new_one_comes_before_the_obstacles() -> None:
    assert difference(replace(RECIPE, chunks=(3, 1), unit_cm=5)) == [
        "-chunks: [2,1]        # wide",
        "+chunks: [3, 1]       # wide",
        "+unit_cm: 5",
    ]


def test_a_row_that_is_switched_off_gets_one_line() -> None:
    off = replace(WALL, enabled=False)
    assert difference(replace(RECIPE, obstacles=(FLOOR, HILL, off))) == ["+    enabled: false"]


def test_a_row_with_a_key_that_does_not_follow_from_it_gets_that_key() -> None:
    soft = replace(HILL, softness=30)
    added = ["+    softness: 30", f"+    key: {HILL.key}"]
    assert difference(replace(RECIPE, obstacles=(FLOOR, soft, WALL))) == added


def test_a_row_without_a_key_stays_without_one_and_keeps_its_comments() -> None:
    soft = replace(HILL, softness=30, key=None)
    assert difference(replace(RECIPE, obstacles=(FLOOR, soft, WALL))) == ["+    softness: 30"]
    lower = replace(FLOOR, levels=2, key=None)
    assert difference(replace(RECIPE, obstacles=(lower, soft, WALL))) == [
        "-  - {kind: random,   levels: 3}   # rough",
        "+  - {kind: random, levels: 2}     # rough",
        "+    softness: 30",
    ]


def test_a_parameter_that_is_the_default_again_leaves_the_file_and_the_comments_stay() -> None:
    text = TEXT.replace("    levels: 5\n", "    levels: 5\n    softness: 30\n")
    plain = replace(recipe_of(text).obstacles[1], softness=0, key=None)
    assert text_after(text, replace(RECIPE, obstacles=(FLOOR, plain, WALL)), ".yaml") == TEXT


def test_a_row_is_added_and_removed_with_its_comment() -> None:
    peak = Peak(levels=3, first=(1, 1), last=(2, 2), key="one")
    assert difference(replace(RECIPE, obstacles=(*RECIPE.obstacles, peak))) == [
        "+  - {kind: peak, levels: 3, first: [1, 1], last: [2, 2], key: one}"
    ]
    removed = difference(replace(RECIPE, obstacles=(FLOOR, WALL)))
    assert removed[0] == "-  - kind: peak        # the hill"
    assert not [line for line in removed if line.startswith("+")]


def test_rows_in_another_order_keep_their_comments() -> None:
    after = text_after(TEXT, replace(RECIPE, obstacles=(WALL, HILL, FLOOR)), ".yaml")
    assert all(comment in after for comment in ("# rough", "# the hill", "# a wall", "# the floor", "# the end"))


def test_a_file_without_obstacles_gets_and_loses_them() -> None:
    empty = "seed: 3 # mine\n"
    peak = Peak(levels=3, key="one")
    filled = text_after(empty, replace(recipe_of(empty), obstacles=(peak,)), ".yaml")
    assert filled.startswith("seed: 3 # mine\nobstacles:\n")
    assert recipe_of(text_after(filled, recipe_of(empty), ".yaml")) == recipe_of(empty)


def test_the_seed_that_was_drawn_for_a_file_without_one_is_written() -> None:
    text = "chunk_size: 5 # small\n"
    recipe = recipe_of(text)
    assert recipe_of(text_after(text, recipe, ".yaml")).seed == recipe.seed


def test_line_ends_of_other_systems_stay() -> None:
    after = text_after(TEXT.replace("\n", "\r\n"), replace(RECIPE, unit_cm=5), ".yaml")
    assert after.replace("\r\n", "") == after.replace("\r\n", "\n").replace("\n", "")
    assert "# the end\r\n" in after


def test_json_stays_json_and_keeps_its_schema() -> None:
    before = '{"$schema": "rsegen.json", "seed": 3}'
    after = json.loads(text_after(before, RECIPE, ".json"))
    assert after.pop("$schema") == "rsegen.json"
    assert after == json.loads(to_json(RECIPE, derived_keys=False))


@pytest.mark.parametrize("text", ["a: &x [1]\nb: *x\n", "[]", "{", "\t", "obstacles: 5\n", "- 1\n"])
def test_what_was_no_recipe_is_written_anew(text: str) -> None:
    assert recipe_of(text_after(text, RECIPE, ".yaml")) == RECIPE


@given(st.sampled_from(sorted(EXAMPLES)), recipes())
def test_any_recipe_can_be_saved_over_any_other(name: str, recipe: Recipe) -> None:
    assert recipe_of(text_after(EXAMPLES[name].read_text("utf-8"), recipe, ".yaml")) == recipe
