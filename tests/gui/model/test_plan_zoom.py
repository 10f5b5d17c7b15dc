"""The plan closer by, without Qt."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rsegen import Random, Recipe, build
from rsegen.gui.model.plan_layout import PlanLayout, fit, resized, shifted, visible, zoomed

AREA = (30.0, 5.0, 300.0, 240.0)
FIELD = build(Recipe(seed=1, chunk_size=8, chunks=(3, 2), obstacles=[Random(levels=5)]))
FITTED = fit(FIELD, AREA)
POINTS = st.tuples(st.floats(30, 330), st.floats(5, 245))
SHIFTS = st.tuples(st.floats(-500, 500), st.floats(-500, 500))
FACTORS = st.floats(0.2, 8)


def covers(layout: PlanLayout) -> bool:
    """Whether no room of the area is lost along an axis along which the map is larger than it."""
    left, top, width, height = layout.area
    fits_x, fits_y = width <= AREA[2], height <= AREA[3]
    x = left <= AREA[0] + 1e-6 and left + width >= AREA[0] + AREA[2] - 1e-6
    y = top <= AREA[1] + 1e-6 and top + height >= AREA[1] + AREA[3] - 1e-6
    return (fits_x or x) and (fits_y or y)


@given(st.lists(st.tuples(POINTS, FACTORS), min_size=1, max_size=6), SHIFTS)
def test_the_map_fills_the_area_at_any_zoom_and_place(
    steps: list[tuple[tuple[float, float], float]], by: tuple[float, float]
) -> None:
    layout = FITTED
    for point, factor in steps:
        layout = zoomed(layout, FITTED, AREA, point, factor)
        assert covers(layout)
        assert FITTED.side <= layout.side <= 80
        assert covers(shifted(layout, AREA, by))


@given(POINTS)
def test_the_cell_under_the_cursor_stays_there(point: tuple[float, float]) -> None:
    closer = zoomed(FITTED, FITTED, AREA, (180, 125), 4)
    again = zoomed(closer, FITTED, AREA, point, 1.5)
    for layout in (closer, again):
        assert layout.cell_at(point) is not None
    assert (point[0] - again.left) / again.side == pytest.approx((point[0] - closer.left) / closer.side)
    assert (again.bottom - point[1]) / again.side == pytest.approx((closer.bottom - point[1]) / closer.side)


def test_farther_than_the_whole_map_is_the_whole_map() -> None:
    closer = zoomed(FITTED, FITTED, AREA, (60, 60), 3)
    assert zoomed(closer, FITTED, AREA, (200, 100), 0.1) == FITTED


def test_only_cells_of_the_area_are_visible() -> None:
    assert visible(FITTED, AREA) == (slice(0, FIELD.shape[0]), slice(0, FIELD.shape[1]))
    closer = zoomed(FITTED, FITTED, AREA, (180, 125), 4)
    x, y = visible(closer, AREA)
    assert closer.cell_at((AREA[0], AREA[1] + AREA[3] - 0.01)) == (x.start, y.start)
    assert closer.cell_at((AREA[0] + AREA[2] - 0.01, AREA[1])) == (x.stop - 1, y.stop - 1)


def test_in_another_size_the_same_cell_is_in_the_middle_and_as_large() -> None:
    closer = zoomed(FITTED, FITTED, AREA, (180, 125), 4)
    wide = (30.0, 5.0, 500.0, 240.0)
    found = resized(closer, fit(FIELD, wide), AREA, wide)
    assert found.side == closer.side
    assert found.cell_at((280, 125)) == closer.cell_at((180, 125))
    assert resized(FITTED, fit(FIELD, wide), AREA, wide) == fit(FIELD, wide)
