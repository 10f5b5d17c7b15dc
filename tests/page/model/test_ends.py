"""Ends that are straightened or fixed are ends that the kind allows."""

from __future__ import annotations

from typing import Literal

import pytest

from rsegen import Recipe
from rsegen.obstacles import KINDS
from rsegen.page.model.actions import ends_of, fixed, with_end_at
from rsegen.recipe.building import placed
from rsegen.recipe.codec import decode

SIZES = [{"chunk_size": 10, "chunks": [1, 1]}, {"chunk_size": 5, "chunks": [4, 2]}, {"chunk_size": 1, "chunks": [1, 3]}]


@pytest.mark.parametrize("size", SIZES, ids=str)
@pytest.mark.parametrize("kind", KINDS)
def test_a_random_position_is_fixed_where_it_was_drawn(kind: str, size: dict[str, object]) -> None:
    entry = {"kind": kind, "levels": 5, "key": "one"}
    given = {"seed": 3, "maps": 2, "ground_level": 4, **size}
    recipe = decode({**given, "obstacles": [entry]})
    for index in range(2):
        found = fixed(entry, recipe, index)
        again = decode({**given, "obstacles": [dict(found)]})
        first, last, patch = placed(recipe, recipe.obstacles[0], index)
        assert (found["first"], found["last"]) == (list(first), list(last))
        assert placed(again, again.obstacles[0], index)[:2] == (first, last)
        assert placed(again, again.obstacles[0], index)[2].window == patch.window


@pytest.mark.parametrize(
    "entry",
    [
        {"kind": "peek", "levels": 5},
        {"kind": "peak", "levels": "high"},
        {"kind": "random", "levels": 2, "counts": [1, 1]},
    ],
)
def test_an_invalid_row_stays_as_it_is(entry: dict[str, object]) -> None:
    assert fixed(entry, Recipe(seed=1), 0) == entry


MAP = Recipe(seed=1)


@pytest.mark.parametrize(
    ("cell", "first", "last"), [((5, 6), [3, 6], [8, 6]), ((9, 0), [4, 0], [9, 0]), ((0, 9), [0, 9], [5, 9])]
)
def test_an_obstacle_is_moved_by_its_middle_within_the_map(
    cell: tuple[int, int], first: list[int], last: list[int]
) -> None:
    barrier = {"kind": "horizontal_barrier", "levels": 3, "first": [2, 4], "last": [7, 4]}
    moved = with_end_at(barrier, "both", cell, MAP, 0)
    assert (moved["first"], moved["last"]) == (first, last)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("end", ["first", "last"])
def test_the_other_end_of_a_random_obstacle_stays_where_it_was_drawn(kind: str, end: Literal["first", "last"]) -> None:
    entry = {"kind": kind, "levels": 5, "key": "one"}
    before = ends_of(entry, MAP, 3)
    moved = with_end_at(entry, end, (4, 4), MAP, 3)
    after = ends_of(moved, MAP, 3)
    assert before is not None
    assert after is not None
    assert moved[end] == [4, 4]
    if kind != "horizontal_barrier":
        assert {**after, end: before[end]} == before


def test_an_obstacle_outside_the_map_has_no_ends_there() -> None:
    assert ends_of({"kind": "peak", "levels": 5, "first": [12, 0], "last": [13, 4]}, MAP, 0) is None
