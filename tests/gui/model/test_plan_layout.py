"""Pixels, field cells and block cells of a plan, without Qt."""

from __future__ import annotations

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rsegen import Random, Recipe, StepField, build
from rsegen.gui.model.plan_layout import PlanLayout, fit, ticks

BOUNDARIES = ("none", "divided", "outer")


def field(boundary: str) -> StepField:
    obstacles = [Random(levels=5)]
    return build(Recipe(seed=1, chunk_size=3, chunks=(3, 2), boundary=boundary, obstacles=obstacles), 0)


def layout(boundary: str = "divided", ratio: float = 1.0) -> PlanLayout:
    return fit(field(boundary), (20.0, 5.0, 400.0, 300.0), ratio)


@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_the_middle_of_every_block_leads_back_to_it(boundary: str) -> None:
    plan = layout(boundary)
    for block in itertools.product(range(9), range(6)):
        cell = plan.cell_at(plan.middle(block))
        assert cell == plan.cell_of(block)
        assert plan.block_of(cell) == plan.nearest_block(plan.middle(block)) == block


@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_every_cell_is_a_block_or_a_frame(boundary: str) -> None:
    found, plan = field(boundary), layout(boundary)
    for cell in itertools.product(range(found.shape[0]), range(found.shape[1])):
        assert (plan.block_of(cell) is None) == found.frame[cell]


def test_north_is_up_and_east_is_right() -> None:
    plan = layout()
    assert plan.middle((0, 5))[1] < plan.middle((0, 0))[1]
    assert plan.middle((8, 0))[0] > plan.middle((0, 0))[0]


@given(st.floats(-1e4, 1e4), st.floats(-1e4, 1e4))
def test_the_nearest_block_is_on_the_map(x: float, y: float) -> None:
    found = layout().nearest_block((x, y))
    assert 0 <= found[0] < 9
    assert 0 <= found[1] < 6


def test_a_point_outside_the_map_has_no_cell() -> None:
    plan = layout()
    left, top, width, height = plan.area
    assert plan.cell_at((left - 1, top + 1)) is None
    assert plan.cell_at((left + width + 1, top + 1)) is None
    assert plan.cell_at((left + 1, top + height - 1)) == (0, 0)


def test_between_two_frames_the_nearest_block_is_the_one_on_the_same_side() -> None:
    plan = layout()
    x, y = plan.middle((2, 0))
    assert plan.nearest_block((x + plan.side, y)) == (2, 0)
    assert plan.nearest_block((x + 2 * plan.side, y)) == (3, 0)


def test_steps_stop_at_the_rim() -> None:
    assert layout().moved((0, 5), (-1, 1)) == (0, 5)
    assert layout().moved((2, 2), (1, 0)) == (3, 2)


@pytest.mark.parametrize("ratio", [1.0, 1.25, 1.5, 2.0])
def test_cells_are_whole_pixels_of_the_screen_and_fill_the_room(ratio: float) -> None:
    plan = layout(ratio=ratio)
    assert plan.side * ratio == pytest.approx(round(plan.side * ratio))
    left, top, width, height = plan.area
    assert left >= 20
    assert top >= 5
    assert width <= 400
    assert height <= 300
    assert (plan.side + 1 / ratio) * 15 > 400 or (plan.side + 1 / ratio) * 10 > 300


@pytest.mark.parametrize(("cells", "side", "step"), [(9, 30, 1), (9, 16, 2), (40, 11, 5), (1000, 0.5, 100)])
def test_a_ruler_numbers_as_many_cells_as_it_has_room_for(cells: int, side: float, step: int) -> None:
    assert ticks(cells, side, room=30) == range(0, cells, step)
