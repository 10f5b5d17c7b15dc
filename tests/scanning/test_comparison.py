"""Two fields cell by cell."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import rsegen
from rsegen import Random, Recipe, StepField
from rsegen.errors import ParameterError
from rsegen.scanning.comparison import Comparison, compared


@pytest.fixture(scope="module")
def field() -> StepField:
    recipe = Recipe(seed=3, chunks=(2, 1), chunk_size=4, obstacles=(Random(levels=5),))
    return rsegen.build(recipe, 0)


def test_a_field_equals_itself_and_itself_turned(field: StepField) -> None:
    assert compared(field, field).is_equal
    for turns in range(4):
        other = replace(field, levels=np.rot90(field.levels, turns).copy(), frame=np.rot90(field.frame, turns).copy())
        found = compared(other, field)
        assert found.is_equal
        assert found.turns == -turns % 4


def test_every_change_is_named_with_both_heights(field: StepField) -> None:
    levels = field.levels.copy()
    x, y = np.argwhere((levels > 0) & ~field.frame)[5]
    levels[x, y] -= 1
    found = compared(replace(field, levels=levels), field)
    assert list(found.changes()) == [(x, y, field.heights[x, y] - field.unit, field.heights[x, y])]
    assert found.differences[x, y] == pytest.approx(-field.unit)
    assert not found.is_equal


def test_a_cell_that_was_not_seen_is_neither_right_nor_wrong(field: StepField) -> None:
    heights = field.heights.copy()
    heights[1, 1] = np.nan
    found = Comparison(heights=heights, wanted=field, tolerance=0.05)
    assert not found.wrong.any()
    assert not found.is_equal


def test_a_block_width_that_was_calculated_is_the_one_that_was_given() -> None:
    """As floats 8.9 cm are 0.08900000000000001 m."""
    wanted = rsegen.build(Recipe(seed=1, chunk_size=3, block_width_cm=8.9), 0)
    stands = replace(wanted, block_width=0.089)
    assert stands.block_width != wanted.block_width
    assert rsegen.compare(stands, wanted).comparison.is_equal


def test_other_sizes_and_other_blocks_are_refused(field: StepField) -> None:
    smaller = rsegen.build(Recipe(seed=1, chunk_size=5), 0)
    with pytest.raises(ParameterError, match=r"^the maps have 7 x 7 and 12 x 6 cells"):
        compared(smaller, field)
    with pytest.raises(ParameterError, match="20 and 10 cm wide"):
        compared(replace(field, block_width=0.2), field)
