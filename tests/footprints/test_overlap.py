"""Which cells a turned rectangle overlaps, and whether two turned rectangles are apart."""

from __future__ import annotations

from math import cos, pi, sin

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from rsegen.footprints import Rectangle
from rsegen.footprints.search import apart, overlapped, reach
from tests.footprints.polygons import area, clipped, corners, covered

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


@given(LENGTHS, LENGTHS, SHIFTS, st.tuples(st.floats(-0.6, 0.6), st.floats(-0.6, 0.6)), YAWS, YAWS)
def test_two_poses_are_apart_exactly_if_no_part_of_one_is_in_the_other(
    length: float, width: float, shift: float, at: tuple[float, float], yaw: float, other_yaw: float
) -> None:
    """Clipping polygons is another way than projecting onto axes; within a micrometre of touching either is right."""
    rectangle = Rectangle.around(length, width).ahead(shift)
    polygon = []
    for x, y in corners(rectangle, *at, other_yaw):  # in the frame of the first
        polygon.append((cos(yaw) * x + sin(yaw) * y, cos(yaw) * y - sin(yaw) * x))
    common = polygon
    for axis, limit, sign in ((0, rectangle[2], 1), (0, rectangle[0], -1), (1, rectangle[3], 1), (1, rectangle[1], -1)):
        common = clipped(common, axis, limit, sign)
    poses = np.array([at[0]]), np.array([at[1]]), np.array([other_yaw])
    if area(common) > 1e-6:
        assert not apart(rectangle, 0.0, (0.0, 0.0, yaw), *poses)[0]
    elif not common:
        assert apart(rectangle, -1e-6, (0.0, 0.0, yaw), *poses)[0]
