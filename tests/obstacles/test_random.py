"""Random obstacles of counted blocks, and with a largest step."""

from __future__ import annotations

import time
from collections.abc import Mapping

import numpy as np
import pytest

import rsegen
from rsegen.errors import ParameterError

COUNTS = (9, 27, 33, 21, 10)


def made(place: Mapping[str, object] | None = None, side: int = 10, **values: object) -> rsegen.Recipe:
    obstacle = rsegen.Random(**{"levels": 5, "key": "k", **values, **(place or {})})  # type: ignore[arg-type]
    return rsegen.Recipe(seed=3, chunk_size=side, boundary="none", obstacles=[obstacle])


def test_counts_of_blocks_are_met() -> None:
    maps = [rsegen.build(made(counts=COUNTS), index) for index in range(5)]
    assert all(one.level_counts() == dict(enumerate(COUNTS)) for one in maps)
    assert len({one.levels.tobytes() for one in maps}) == 5


@pytest.mark.parametrize("limit", [1, 2, 3])
@pytest.mark.parametrize("side", [10, 40])
def test_max_step_reorders_the_same_blocks(limit: int, side: int) -> None:
    for index in range(3):
        free, ordered = (rsegen.build(made(side=side, max_step=most), index) for most in (None, limit))
        assert ordered.level_counts() == free.level_counts()
        assert rsegen.metrics(ordered).steps.highest == pytest.approx(limit * 0.1)


def test_max_step_reorders_counted_blocks() -> None:
    field = rsegen.build(made(counts=COUNTS, max_step=1))
    assert field.level_counts() == dict(enumerate(COUNTS))
    assert max(rsegen.metrics(field).steps.counts) == 1


def test_blocks_without_large_steps_keep_their_order() -> None:
    assert (rsegen.build(made(max_step=4)).levels == rsegen.build(made()).levels).all()


def test_an_impossible_order_is_refused() -> None:
    with pytest.raises(rsegen.UserError, match=r"obstacles\[0\].max_step: 3: no order of these blocks was found"):
        rsegen.build(made(counts=(50, 0, 0, 0, 50), max_step=3))


def test_counts_that_do_not_fill_the_cells_are_refused() -> None:
    assert rsegen.build(made({"first": (1, 1), "last": (2, 3)}, counts=(1, 2, 0, 2, 1))).levels.sum() == 12
    for place, counts, says in (
        ({}, (9, 27, 33, 21, 9), "counts: 99 blocks for 100 cells: the counts must add up to the number of cells"),
        ({"first": "random"}, COUNTS, "counts: needs a region of fixed size; set first and last"),
        ({}, (1, 2), "counts: 2 counts for 5 levels; expected one for each level"),
    ):
        with pytest.raises(rsegen.UserError, match=says):
            made(place, counts=counts)
    for values in ({"weights": (1, 1, 1, 1, 1)}, {"softness": 10}):
        with pytest.raises(rsegen.UserError, match="excludes weights and softness"):
            made(counts=COUNTS, **values)


def test_the_order_is_the_same_for_the_same_seed() -> None:
    one, other = (rsegen.build(made(side=30, max_step=1), 7) for _ in (0, 1))
    assert np.array_equal(one.levels, other.levels)


def test_levels_with_a_gap_above_the_largest_step_are_refused_before_any_order_is_tried() -> None:
    start = time.process_time()
    recipe = made(side=300, counts=(80_000, 0, 0, 0, 10_000), max_step=3)
    with pytest.raises(ParameterError, match=r"max_step: 3: no order of these blocks was found"):
        rsegen.build(recipe)
    assert time.process_time() - start < 5
