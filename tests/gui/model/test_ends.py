"""Ends that are straightened or fixed are ends that the kind allows."""

from __future__ import annotations

import pytest

from rsegen import Recipe
from rsegen.field.obstacles import KINDS
from rsegen.gui.model.ends import fixed
from rsegen.recipe.building import placed
from rsegen.recipe.codec import decode

SIZES = [{"chunk_size": 10, "chunks": [1, 1]}, {"chunk_size": 5, "chunks": [4, 2]}, {"chunk_size": 1, "chunks": [1, 3]}]


@pytest.mark.parametrize("size", SIZES, ids=str)
@pytest.mark.parametrize("kind", KINDS)
def test_a_random_position_is_fixed_where_it_was_drawn(kind: str, size: dict[str, object]) -> None:
    entry = {"kind": kind, "max_height": 5, "key": "one"}
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
        {"kind": "peek", "max_height": 5},
        {"kind": "peak", "max_height": "high"},
        {"kind": "random", "max_height": 2, "counts": [1, 1]},
    ],
)
def test_what_is_invalid_stays_as_it_is(entry: dict[str, object]) -> None:
    assert fixed(entry, Recipe(seed=1), 0) == entry
