"""Which cells each tool paints."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from rsegen.gui.model.painting import UNPAINTED, Brush, Painted, Strokes, Tool, connected, rectangle

LEVELS = np.array([[0, 0, 1], [1, 0, 1], [1, 1, 0]], dtype=np.int16)


def test_cells_are_painted_at_once_and_without_gaps() -> None:
    strokes = Strokes()
    assert strokes.begin(Brush(Tool.CELLS, 4), (0, 0), LEVELS, erases=False) == Painted(((0, 0),), 4, 1)
    assert strokes.go_to((0, 0)) is None
    assert strokes.go_to((2, 2)) == Painted(((0, 0), (1, 1), (2, 2)), 4, 1)
    assert strokes.end() is None
    assert strokes.go_to((0, 1)) is None


def test_a_rectangle_is_painted_when_the_mouse_is_released() -> None:
    strokes = Strokes()
    assert strokes.begin(Brush(Tool.RECTANGLE, 4), (2, 1), LEVELS, erases=True) is None
    assert strokes.go_to((1, 0)) is None
    assert strokes.band == ((2, 1), (1, 0))
    assert strokes.end() == Painted(((1, 0), (1, 1), (2, 0), (2, 1)), UNPAINTED, 1)
    assert strokes.band is None


def test_a_rectangle_that_is_given_up_paints_nothing() -> None:
    strokes = Strokes()
    strokes.begin(Brush(Tool.RECTANGLE, 4), (2, 1), LEVELS, erases=False)
    strokes.cancel()
    assert strokes.end() is None


def test_filling_goes_as_far_as_the_level_and_not_across_corners() -> None:
    assert set(connected(LEVELS, (0, 1))) == {(0, 0), (0, 1), (1, 1)}
    assert connected(LEVELS, (2, 2)) == ((2, 2),)
    painted = Strokes().begin(Brush(Tool.FILL, 7), (1, 0), LEVELS, erases=False)
    assert painted
    assert (set(painted.cells), painted.level) == ({(1, 0), (2, 0), (2, 1)}, 7)


def test_the_keyboard_paints_strokes_of_its_own() -> None:
    strokes = Strokes()
    strokes.cursor = (1, 2)
    assert strokes.paint_here(3) == Painted(((1, 2),), 3, 1)
    assert strokes.paint_here(UNPAINTED) == Painted(((1, 2),), UNPAINTED, 2)


@given(st.lists(st.integers(0, 2), min_size=30, max_size=30), st.integers(0, 4), st.integers(0, 5))
def test_filling_twice_from_any_filled_cell_is_the_same(numbers: list[int], x: int, y: int) -> None:
    levels = np.array(numbers, dtype=np.int16).reshape(5, 6)
    found = set(connected(levels, (x, y)))
    assert all(set(connected(levels, cell)) == found for cell in found)
    assert {levels[cell] for cell in found} == {levels[x, y]}


def test_a_rectangle_has_all_cells_between_its_corners() -> None:
    assert rectangle((3, 1), (2, 1)) == ((2, 1), (3, 1))
    assert len(rectangle((0, 0), (4, 6))) == 35
