"""Robots start on even ground, apart, and never inside a block."""

from __future__ import annotations

from math import hypot

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rsegen import Placement, Random, Recipe, StepField, build
from rsegen.errors import ParameterError
from rsegen.simulation.driving.start_poses import DROP_HEIGHT, GAP, adjacent_pose, poses_on_map

SIZE = (0.3, 0.2, 0.2)


def field(seed: int, blocks: int = 20, levels: int = 4) -> StepField:
    random = Placement(obstacle=Random(max_height=levels))
    return build(Recipe(chunk_size=blocks, boundary="none", seed=seed, obstacles=(random,)))


def under(found: StepField, x: float, y: float, reach: float) -> np.ndarray:
    """The heights of all blocks that a circle about a place touches."""
    edges_x, edges_y = found.edges()
    near_x = np.maximum(np.maximum(edges_x[:-1] - x, x - edges_x[1:]), 0)
    near_y = np.maximum(np.maximum(edges_y[:-1] - y, y - edges_y[1:]), 0)
    return found.heights[np.hypot(near_x[:, None], near_y[None, :]) < reach - 1e-9]


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 1000))
def test_on_top_of_everything_under_them_and_apart(seed: int) -> None:
    found, reach = field(seed), hypot(*SIZE[:2]) / 2
    places = poses_on_map(found, [SIZE] * 3, np.random.default_rng(seed))
    for number, place in enumerate(places):
        assert place.z - DROP_HEIGHT >= under(found, place.x, place.y, reach).max() - 1e-9
        assert abs(place.x) + reach <= 1
        for other in places[:number]:
            assert hypot(place.x - other.x, place.y - other.y) > 2 * reach + GAP


def test_where_there_is_even_ground_they_stand_on_it() -> None:
    levels = np.random.default_rng(1).integers(0, 5, (20, 20)).astype(np.int16)
    levels[3:10, 8:15] = 2
    found = StepField(levels=levels, frame=levels < 0, block_width=0.1, unit=0.1, frame_height=0.1)
    (place,) = poses_on_map(found, [SIZE], np.random.default_rng(1))
    assert set(under(found, place.x, place.y, 0.18).tolist()) == {0.2}
    assert place.z == pytest.approx(0.2 + DROP_HEIGHT)


def test_what_is_too_large_or_too_many_is_said() -> None:
    with pytest.raises(ParameterError, match="robot: it is too large to start on 4 x 4 cells"):
        poses_on_map(field(1, blocks=4), [(0.5, 0.5, 0.2)], np.random.default_rng(1))
    with pytest.raises(ParameterError, match="robots: not enough room on 10 x 10 cells; give fewer"):
        poses_on_map(field(1, blocks=10), [SIZE] * 9, np.random.default_rng(1))


def test_beside_the_map_is_beyond_its_rim_on_the_ground() -> None:
    place = adjacent_pose(field(1), SIZE, 0.5)
    assert place.x + SIZE[0] / 2 == pytest.approx(-1 - GAP)
    assert (place.y, place.z, place.yaw) == (0.5, DROP_HEIGHT, 0)
