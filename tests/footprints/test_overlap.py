"""Which cells a turned rectangle overlaps, and whether two turned rectangles are apart."""

from __future__ import annotations

from math import pi

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from rsegen.footprints import Rectangle
from rsegen.footprints.search import apart, overlapped, reach
from tests.footprints.polygons import corners, covered

LENGTHS = st.floats(0.02, 0.6)
YAWS = st.one_of(st.sampled_from([number * pi / 8 for number in range(16)]), st.floats(0, 2 * pi))
SHIFTS = st.floats(-0.2, 0.2)


@given(LENGTHS, LENGTHS, SHIFTS, YAWS, st.tuples(st.floats(0, 0.1), st.floats(0, 0.1)))
def test_a_cell_is_overlapped_exactly_if_the_rectangle_covers_some_of_it(
    length: float, width: float, shift: float, yaw: float, at: tuple[float, float]
) -> None:
    rectangle = Rectangle.around(length, width).ahead(shift)
    cells = reach(rectangle, 0.1)
    edges = np.asarray(np.arange(-cells, cells + 2) * 0.1, dtype=np.float64)
    areas = covered(rectangle, *at, yaw, (edges, edges))
    found = overlapped(rectangle, yaw, at, cells, 0.1)
    assert found[areas > 1e-7].all()
    assert areas[found].min() > 0
    np.testing.assert_allclose(areas.sum(), length * width, rtol=1e-6)


def test_a_rectangle_that_only_touches_a_cell_does_not_overlap_it() -> None:
    found = overlapped(Rectangle.around(0.2, 0.2), pi / 2, (0.0, 0.0), 2, 0.1)
    assert found.sum() == 4


@given(LENGTHS, LENGTHS, YAWS, YAWS, st.floats(-0.8, 0.8), st.floats(-0.8, 0.8))
def test_rectangles_are_apart_exactly_if_no_cell_of_one_is_under_the_other(
    length: float, width: float, one: float, other: float, x: float, y: float
) -> None:
    """The second one, in whose frame the first one is turned, is the cell of the polygons."""
    rectangle = Rectangle.around(length, width)
    found = apart(rectangle, 0.0, (0.0, 0.0, one), np.array([x]), np.array([y]), np.array([other]))[0]
    turned = corners(Rectangle(x, y, x, y), 0, 0, -other)[0]
    edges = (turned[0] + np.array([-1, 1]) * length / 2, turned[1] + np.array([-1, 1]) * width / 2)
    common = covered(rectangle, 0, 0, one - other, edges)[0, 0]
    assert found == (common == 0) or common < 1e-7
