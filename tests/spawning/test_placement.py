"""Room for something new, and a map as it stands."""

from __future__ import annotations

from math import cos, hypot, pi, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rsegen
from rsegen.simulators.poses import Pose
from rsegen.spawning.placement import GAP, Area, SpawnedMap, free_area

METRES = st.floats(-20, 20)
SIZES = st.floats(0, 3)
TAKEN = st.lists(st.builds(Area, METRES, METRES, SIZES, SIZES), max_size=8)
FIELD = rsegen.build(
    rsegen.Recipe(seed=3, chunk_size=6, chunks=(2, 1), obstacles=(rsegen.Random(levels=4),)),
    0,
)


@given(half_x=st.floats(0.1, 3), half_y=st.floats(0.1, 3), taken=TAKEN)
def test_a_free_place_is_clear_of_all_models(half_x: float, half_y: float, taken: list[Area]) -> None:
    place = free_area(half_x, half_y, taken)
    assert (place.half_x, place.half_y) == (half_x, half_y)
    for other in taken:
        apart = (abs(place.x - other.x) - half_x - other.half_x, abs(place.y - other.y) - half_y - other.half_y)
        assert max(apart) > GAP - 0.002


def test_the_origin_is_the_first_choice_and_its_neighbour_the_second() -> None:
    assert free_area(1, 2, [])[:2] == (0, 0)
    assert free_area(1, 2, [Area(0, 0)])[:2] == (2 + GAP, 0)
    assert free_area(2, 1, [Area(0, 0)])[:2] == (0, 2 + GAP)


@given(half_x=st.floats(0.1, 3), half_y=st.floats(0.1, 3), taken=TAKEN)
def test_no_place_of_the_grid_that_is_nearer_is_free(half_x: float, half_y: float, taken: list[Area]) -> None:
    place = free_area(half_x, half_y, taken)
    away, step_x, step_y = hypot(place.x, place.y), 2 * half_x + GAP, 2 * half_y + GAP
    nearer = (
        (i * step_x, j * step_y)
        for i in range(-int(away / step_x), int(away / step_x) + 1)
        for j in range(-int(away / step_y), int(away / step_y) + 1)
        if hypot(i * step_x, j * step_y) < away - 0.002
    )
    for x, y in nearer:
        assert any(
            max(abs(x - other.x) - half_x - other.half_x, abs(y - other.y) - half_y - other.half_y) < GAP + 0.002
            for other in taken
        )


@given(x=METRES, y=METRES, yaw=st.floats(-pi, pi))
def test_the_area_of_a_turned_map_reaches_to_its_corners(x: float, y: float, yaw: float) -> None:
    placed = SpawnedMap(name="rse_0000", field=FIELD, at=Pose(x=x, y=y, z=0, yaw=yaw))
    half_length, half_width = FIELD.extent[0] / 2, FIELD.extent[1] / 2
    corners = [
        complex(a, b) * complex(cos(yaw), sin(yaw))
        for a in (-half_length, half_length)
        for b in (-half_width, half_width)
    ]
    assert placed.area == pytest.approx((x, y, max(at.real for at in corners), max(at.imag for at in corners)))


@given(x=METRES, y=METRES, z=st.floats(-1, 1), yaw=st.floats(-pi, pi), data=st.data())
def test_the_top_under_a_place_is_that_of_its_cell(
    x: float, y: float, z: float, yaw: float, data: st.DataObject
) -> None:
    i, j = (data.draw(st.integers(0, cells - 1)) for cells in FIELD.shape)
    east, north = ((line[k] + line[k + 1]) / 2 for line, k in zip(FIELD.edges(), (i, j), strict=True))
    at = Pose(x=x + east * cos(yaw) - north * sin(yaw), y=y + east * sin(yaw) + north * cos(yaw), z=0)
    placed = SpawnedMap(name="rse_0000", field=FIELD, at=Pose(x=x, y=y, z=z, yaw=yaw))
    assert placed.top(at) == pytest.approx(z + FIELD.heights[i, j])
    assert placed.covers(at, 0)
    near = FIELD.heights[max(i - 1, 0) : i + 2, max(j - 1, 0) : j + 2]
    assert placed.top(at, FIELD.block_width) == pytest.approx(z + near.max())
    assert placed.top(at, 100) == pytest.approx(z + FIELD.heights.max())


@given(x=METRES, y=METRES, yaw=st.floats(-pi, pi), angle=st.floats(-pi, pi))
def test_outside_a_map_the_ground_is_flat(x: float, y: float, yaw: float, angle: float) -> None:
    placed = SpawnedMap(name="rse_0000", field=FIELD, at=Pose(x=x, y=y, z=0.25, yaw=yaw))
    away = hypot(*FIELD.extent) / 2 + 0.2
    at = Pose(x=x + away * cos(angle), y=y + away * sin(angle), z=0)
    assert placed.top(at) == 0.25
    assert not placed.covers(at, 0.1)
    _, _, half_x, half_y = placed.area
    assert np.hypot(half_x, half_y) >= hypot(*FIELD.extent) / 2 - 1e-9
