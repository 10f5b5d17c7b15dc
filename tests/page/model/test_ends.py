"""Ends that are straightened or fixed are ends that the kind allows."""

from __future__ import annotations

import pytest

from rsegen import Recipe
from rsegen.field.obstacles import KINDS
from rsegen.gui.model.obstacle_ends import fixed, shifted
from rsegen.recipe.building import placed
from rsegen.recipe.codec import decode

SIZES = [{"chunk_size": 10, "chunks": [1, 1]}, {"chunk_size": 5, "chunks": [4, 2]}, {"chunk_size": 1, "chunks": [1, 3]}]


@pytest.mark.parametrize("size", SIZES, ids=str)
@pytest.mark.parametrize("kind", KINDS)
def test_a_random_position_is_fixed_where_it_was_drawn(kind: str, size: dict[str, object]) -> None:
    entry = {"kind": kind, "levels": 5, "key": "one"}
    recipe = decode({"seed": 3, "maps": 5, **size, "obstacles": [entry]})
    for index in range(5):
        found = fixed(entry, recipe, index)
        again = decode({"seed": 3, "maps": 5, **size, "obstacles": [dict(found)]})
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


@pytest.mark.parametrize(
    ("before", "end", "place", "after"),
    [
        pytest.param(([29, 0], [29, 9]), "first", [8, 0], ([8, 0], [8, 9]), id="across: the whole barrier moves"),
        pytest.param(([8, 0], [8, 9]), "last", [3, 9], ([3, 0], [3, 9]), id="by its other end too"),
        pytest.param(([0, 4], [29, 4]), "first", [0, 7], ([0, 7], [29, 7]), id="along x"),
        pytest.param(([8, 0], [8, 9]), "first", [8, 5], ([8, 5], [8, 9]), id="along: it gets shorter"),
        pytest.param(([8, 5], [8, 5]), "last", [12, 5], ([8, 5], [12, 5]), id="of one block: in any direction"),
    ],
)
def test_a_barrier_keeps_its_direction_when_a_coordinate_is_set(
    before: tuple[list[int], list[int]], end: str, place: list[int], after: tuple[list[int], list[int]]
) -> None:
    was = {"kind": "horizontal_barrier", "levels": 5, "first": before[0], "last": before[1]}
    found = shifted(was, {**was, end: place}, end)
    assert (found["first"], found["last"]) == after


def test_an_obstacle_that_may_have_any_ends_keeps_the_other_one() -> None:
    was = {"kind": "peak", "levels": 5, "first": [2, 2], "last": [2, 7]}
    assert shifted(was, {**was, "first": [4, 2]}, "first") == {**was, "first": [4, 2]}
