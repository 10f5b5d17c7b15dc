"""Robots stand level on spots, and nothing else of them is on a block, by another way than that of rsegen."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace
from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rsegen import Random, Recipe, StepField, build
from rsegen.errors import ParameterError
from rsegen.footprints import Footprint, Rectangle, Underside, even_spots, fits
from rsegen.footprints.search import apart
from tests.footprints.polygons import heights_under

WHEELS = tuple(Underside(Rectangle(x, y, x + 0.04, y + 0.02), 0.0) for x in (-0.1, 0.06) for y in (-0.08, 0.06))
HULL = Underside(Rectangle(-0.14, -0.06, 0.16, 0.06), 0.03)
ROVER = Footprint(undersides=(*WHEELS, HULL), limit=0.005, climb=0.02)


def rough(seed: int, blocks: int = 20, levels: int = 4, unit_cm: float = 10, boundary: str = "none") -> StepField:
    random = Random(levels=levels)
    recipe = Recipe(chunk_size=blocks, boundary=boundary, unit_cm=unit_cm, seed=seed, obstacles=(random,))
    return build(recipe)


def flat(blocks: int = 20) -> StepField:
    levels = np.zeros((blocks, blocks), dtype=np.int16)
    return StepField(levels=levels, frame=levels < 0, block_width=0.1, unit=0.1, frame_height=0.1)


@settings(max_examples=10)
@given(st.integers(0, 1000), st.sampled_from(["none", "outer"]), st.sampled_from([0.3, 2, 10]))
def test_wheels_stand_level_and_the_hull_on_nothing(seed: int, boundary: str, unit_cm: float) -> None:
    field = rough(seed, levels=2, unit_cm=unit_cm, boundary=boundary)
    for spot in even_spots(field, ROVER, 2, np.random.default_rng(seed), gap=0.1):
        pose = spot.x, spot.y, spot.yaw
        under = np.concatenate([heights_under(field, wheel.rectangle, *pose) for wheel in WHEELS])
        assert np.ptp(under) <= ROVER.limit
        assert spot.support_difference >= np.ptp(under) - 1e-9
        assert spot.z >= under.max() - 1e-9
        assert heights_under(field, HULL.rectangle, *pose).max() - HULL.bottom < under.max()
        assert spot.difference == pytest.approx(np.ptp(heights_under(field, ROVER.outline, *pose)), abs=unit_cm / 100)
        assert spot.unevenness == 0


@given(st.integers(0, 1000))
@settings(max_examples=10)
def test_robots_are_apart_and_the_same_seed_gives_the_same(seed: int) -> None:
    found, again = (even_spots(flat(), ROVER, 6, np.random.default_rng(seed), gap=0.1) for _ in range(2))
    assert found == again
    for number, one in enumerate(found):
        others = found[:number]
        x, y, yaw = (np.array([getattr(spot, name) for spot in others]) for name in ("x", "y", "yaw"))
        assert apart(ROVER.outline, 0.1 - 1e-6, (one.x, one.y, one.yaw), x, y, yaw).all()


def test_seeds_give_different_places() -> None:
    found = {even_spots(flat(), ROVER, 1, np.random.default_rng(seed))[0] for seed in range(8)}
    assert len(found) > 5


def test_the_one_even_place_is_found_whatever_its_heading() -> None:
    levels = np.random.default_rng(1).integers(0, 5, (20, 20)).astype(np.int16) * 2 + np.indices((20, 20)).sum(0) % 2
    levels = levels.astype(np.int16)
    levels[3:5, 8:12] = 20
    field = StepField(levels=levels, frame=levels < 0, block_width=0.1, unit=0.1, frame_height=0.1)
    (spot,) = even_spots(field, ROVER, 1, np.random.default_rng(1))
    assert spot.difference == 0
    assert spot.yaw % pi == pytest.approx(pi / 2)
    assert spot.z == pytest.approx(2.0)


def test_a_place_from_which_the_robot_can_drive_away_comes_first() -> None:
    levels = np.full((20, 40), 1, dtype=np.int16)
    levels[:, :20] = 9 * ((np.indices((20, 20)) // 5).sum(0) % 2)
    field = StepField(levels=levels, frame=levels < 0, block_width=0.1, unit=0.1, frame_height=0.1)
    spots = [even_spots(field, ROVER, 1, np.random.default_rng(seed))[0] for seed in range(5)]
    assert all(spot.y > 0 for spot in spots)


def test_frames_carry_no_wheels() -> None:
    levels = np.zeros((8, 8), dtype=np.int16)
    frame = np.ones((8, 8), dtype=bool)
    frame[3:5, 2:6] = False
    field = StepField(levels=levels, frame=frame, block_width=0.1, unit=0.1, frame_height=0.0)
    (spot,) = even_spots(field, ROVER, 1, np.random.default_rng(1))
    assert spot.yaw % pi == pytest.approx(pi / 2)


@pytest.mark.parametrize(
    ("field", "count", "message"),
    [
        (flat(2), 1, "robot: too large for 2 x 2 cells; give a smaller robot or a larger map"),
        (flat(5), 9, "count: found even places for . of 9 on this map; give fewer, or add a platform obstacle"),
    ],
)
def test_too_large_or_too_many_values_are_refused(field: StepField, count: int, message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        even_spots(field, ROVER, count, np.random.default_rng(1), gap=0.1)


def stairs() -> StepField:
    levels = (np.indices((12, 12)).sum(0) * 2).astype(np.int16)
    return StepField(levels=levels, frame=levels < 0, block_width=0.1, unit=0.1, frame_height=0.1)


def test_without_an_even_place_the_best_is_named_and_taken_only_on_request() -> None:
    match = "robot: no place is even enough: at the best one the blocks under its wheels or tracks differ by 40 cm, and"
    with pytest.raises(ParameterError, match=match):
        even_spots(stairs(), ROVER, 1, np.random.default_rng(1))
    (spot,) = even_spots(stairs(), ROVER, 1, np.random.default_rng(1), evenest=True)
    assert spot.support_difference == pytest.approx(0.4)
    assert spot.unevenness >= 0.395
    assert spot.z >= heights_under(stairs(), WHEELS[0].rectangle, spot.x, spot.y, spot.yaw).max()


def test_a_largest_difference_under_the_whole_robot_rules_out_holes() -> None:
    levels = np.zeros((4, 4), dtype=np.int16)
    levels[:, [0, 3]] = levels[[0, 3], :] = 5
    field = StepField(levels=levels, frame=levels < 0, block_width=0.1, unit=0.1, frame_height=0.1)
    wide = tuple(Underside(Rectangle(x, y, x + 0.01, y + 0.01), 0.0) for x in (-0.15, 0.14) for y in (-0.15, 0.14))
    (spot,) = even_spots(field, Footprint(undersides=wide, limit=0.01, climb=0.0), 1, np.random.default_rng(1))
    assert spot.difference == pytest.approx(0.5)
    with pytest.raises(ParameterError, match="the blocks under it differ by 50 cm"):
        even_spots(field, Footprint(undersides=wide, limit=0.01, climb=0.0, most=0.1), 1, np.random.default_rng(1))


def test_a_robot_fits_only_where_all_of_it_is_on_the_map() -> None:
    assert fits(flat(4), ROVER)
    assert not fits(flat(2), ROVER)


@pytest.mark.slow
def test_large_maps_are_searched_in_parts() -> None:
    (spot,) = even_spots(rough(1, blocks=600, levels=5), ROVER, 1, np.random.default_rng(1))
    assert spot.unevenness == 0


@pytest.mark.parametrize(("length", "width"), [(100, 100), (100, 0.3), (2.9, 0.1), (1.5, 2.7)])
def test_a_robot_that_is_larger_than_the_map_is_refused_before_memory_is_taken(length: float, width: float) -> None:
    footprint = Footprint.of_size(length, width)
    tracemalloc.start()
    assert not fits(flat(), footprint)
    with pytest.raises(ParameterError, match="too large for 20 x 20 cells"):
        even_spots(flat(), footprint, 1, np.random.default_rng(1))
    taken = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert taken < 60_000_000


def test_a_robot_of_hundreds_of_blocks_is_refused() -> None:
    with pytest.raises(ParameterError, match="too large for blocks of 1 cm"):
        fits(replace(flat(800), block_width=0.01), Footprint.of_size(4, 4))
