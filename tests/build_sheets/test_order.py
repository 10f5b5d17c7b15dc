"""Pallets and blocks are numbered as one reads, with the north above."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given

from rsegen import Recipe, compose
from rsegen.build_sheets.cut_settings import nanometres
from rsegen.build_sheets.timber import building_order, length_counts, name, placing_order
from tests.support.strategies import recipes


@pytest.mark.parametrize(
    ("chunk", "said"), [((0, 0), "A1"), ((25, 2), "Z3"), ((26, 0), "AA1"), ((399, 399), "OJ400"), ((701, 0), "ZZ1")]
)
def test_pallets_are_named_as_the_fields_of_a_chess_board(chunk: tuple[int, int], said: str) -> None:
    assert name(chunk) == said


def test_pallets_are_built_row_by_row_from_the_north_west() -> None:
    pallets = building_order(compose(Recipe(seed=1, chunks=(3, 2), chunk_size=4)))
    assert [each.name for each in pallets] == ["A2", "B2", "C2", "A1", "B1", "C1"]
    assert [each.number for each in pallets] == [1, 2, 3, 4, 5, 6]
    assert [each.corner for each in pallets] == [(0, 4), (4, 4), (8, 4), (0, 0), (4, 0), (8, 0)]


def test_blocks_are_placed_row_by_row_and_empty_cells_are_passed_over() -> None:
    as_read = np.array([[1, 0, 2], [0, 3, 1]], dtype=np.int16)
    assert placing_order(as_read[::-1].T)[:, ::-1].T.tolist() == [[1, 0, 2], [0, 3, 4]]


@given(recipes())
def test_the_pallets_in_order_are_the_map(recipe: Recipe) -> None:
    scene = compose(recipe)
    levels = np.full(recipe.grid.shape, -1)
    for each in building_order(scene):
        (x, y), (n_x, n_y) = each.corner, each.levels.shape
        levels[x : x + n_x, y : y + n_y] = each.levels
        order = placing_order(each.levels)
        assert sorted(order[order > 0].tolist()) == list(range(1, int((each.levels > 0).sum()) + 1))
    assert np.array_equal(levels, scene.field.blocks)


@given(recipes())
def test_the_cut_list_is_the_blocks_of_each_level(recipe: Recipe) -> None:
    field = compose(recipe).field
    expected = {level: count for level, count in field.level_counts().items() if level}
    assert length_counts(field) == {nanometres(level * recipe.unit_cm): count for level, count in expected.items()}
