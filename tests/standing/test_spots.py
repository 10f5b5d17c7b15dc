"""Robots at spots stand there, do not overlap and drive away; the tops of towers, frames and steps are no spots."""

from __future__ import annotations

import time
import tracemalloc
from dataclasses import replace
from math import degrees, pi, radians

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from rsegen import Random, Recipe, StepField, build
from rsegen.errors import ParameterError
from rsegen.robots.base import ROBOTS
from rsegen.standing.body import Body, body_of_size
from rsegen.standing.ground import PaddedGround
from rsegen.standing.lanes import drive_lanes
from rsegen.standing.outlines import Outline, Spot, apart, fits
from rsegen.standing.resting import resting_poses
from rsegen.standing.settling import outer_radius
from rsegen.standing.spots import MOST_TILT, find_spots

KINDS = pytest.mark.parametrize("kind", ["burger", "jackal", "crawler"])


def body(kind: str) -> Body:
    return ROBOTS[kind].body


def rough(seed: int, blocks: int = 20, unit_cm: float = 1, boundary: str = "none") -> StepField:
    return build(
        Recipe(chunk_size=blocks, boundary=boundary, unit_cm=unit_cm, seed=seed, obstacles=(Random(levels=3),))
    )


def field_of(levels: np.ndarray, frame: np.ndarray | None = None) -> StepField:
    frame = np.zeros(levels.shape, bool) if frame is None else frame
    return StepField(levels=levels.astype(np.int16), frame=frame, block_width=0.1, unit=0.1, frame_height=0.0)


def flat(blocks: int = 20) -> StepField:
    return field_of(np.zeros((blocks, blocks)))


def spots_of(field: StepField, robot: Body, count: int, seed: int, gap: float = 0.0) -> tuple[Spot, ...]:
    return find_spots(field, robot, count, np.random.default_rng(seed), gap=gap)


@pytest.mark.slow
@KINDS
@settings(max_examples=5)
@given(seed=st.integers(0, 1000))
@example(seed=140)  # in the first of two ways to stand at once, and in the second when it is put down again
@example(seed=806)
def test_a_robot_at_a_spot_stands_level_on_its_feet_and_drives_away(kind: str, seed: int) -> None:
    field, robot = rough(seed), body(kind)
    for spot in spots_of(field, robot, 1, seed):
        rest = resting_poses(field, robot, spot.x, spot.y, spot.yaw)
        assert rest.stands.all()
        assert rest.pushes.all()
        # Four wheels may stand on three of them in two ways.
        assert float(rest.z[0]) == pytest.approx(spot.z, abs=0.006)
        assert float(rest.tilt[0]) == pytest.approx(spot.tilt, abs=radians(1.5))
        assert kind == "burger" or float(rest.clearance[0]) >= 0.002  # a Burger's caster is always on the ground
        assert spot.tilt <= MOST_TILT + 1e-9
        assert spot.tip_angle > radians(10)
        at = np.array([spot.x]), np.array([spot.y]), np.array([spot.yaw])
        lane = 1.25 * robot.length  # a little more than its length
        assert drive_lanes(PaddedGround.of(field, outer_radius(robot) + 1), robot, *at, lane).passed.all()
        assert spot.reason == ""


@pytest.mark.slow
@KINDS
@settings(max_examples=5)
@given(seed=st.integers(0, 1000))
def test_robots_are_on_the_map_and_apart_and_the_same_seed_gives_the_same(kind: str, seed: int) -> None:
    field, outline = flat(40), Outline.of(body(kind))
    found, again = (spots_of(field, body(kind), 4, seed, gap=0.1) for _ in range(2))
    assert found == again
    for number, spot in enumerate(found):
        assert np.abs(outline.at(spot)).max() <= 2 + 1e-6
        x, y, yaw = (np.array([getattr(other, name) for other in found[:number]]) for name in ("x", "y", "yaw"))
        assert apart(outline, 0.1 - 1e-6, x, y, yaw, spot).all()


def test_seeds_give_different_places() -> None:
    assert len({spots_of(flat(), body("burger"), 1, seed)[0] for seed in range(6)}) == 6


@pytest.mark.slow
@pytest.mark.parametrize("side", [2, 3])
def test_the_top_of_a_tower_is_no_spot_though_it_is_level(side: int) -> None:
    levels = np.zeros((20, 20))
    levels[10 : 10 + side, 10 : 10 + side] = 5
    for seed in range(10):
        assert all(spot.z == pytest.approx(0, abs=1e-6) for spot in spots_of(field_of(levels), body("burger"), 3, seed))


@pytest.mark.slow
def test_where_all_is_towers_the_reason_is_that_it_cannot_drive_away() -> None:
    levels = 5 * ((np.indices((20, 20)) // 2).sum(axis=0) % 2)
    levels[[0, -1]] = levels[:, [0, -1]] = 9  # over the rim it would get away
    with pytest.raises(ParameterError, match="robot: no spot on this map: at the best place it cannot drive away"):
        spots_of(field_of(levels), body("burger"), 1, 1)
    (spot,) = find_spots(field_of(levels), body("burger"), 1, np.random.default_rng(1), evenest=True)
    assert spot.reason.startswith("cannot drive away")
    assert spot.tilt <= MOST_TILT


def test_a_platform_among_rough_blocks_is_found() -> None:
    levels = np.random.default_rng(1).integers(0, 5, (20, 20)) * 2
    levels[3:8, 8:12] = 20
    for seed in range(3):
        (spot,) = spots_of(field_of(levels), body("burger"), 1, seed)
        assert [spot.tilt, spot.z] == pytest.approx([0, 2.0], abs=1e-6)


def test_frames_carry_no_robot() -> None:
    frame = np.ones((10, 10), bool)
    frame[3:5, 1:9] = False
    found = spots_of(field_of(np.zeros((10, 10)), frame), body("burger"), 1, 1)
    assert found[0].yaw % pi == pytest.approx(pi / 2, abs=0.3)


@pytest.mark.slow
def test_nothing_but_the_feet_touches_a_block() -> None:
    levels = np.zeros((12, 12))
    levels[::4, ::4] = 1  # posts of 10 cm: one is always below the Jackal, higher than its hull
    with pytest.raises(ParameterError, match="no spot"):
        spots_of(field_of(levels), body("jackal"), 1, 1)


def test_a_larger_tilt_may_be_allowed_and_is_kept() -> None:
    slope = field_of(np.repeat(np.arange(40)[:, None], 40, axis=1))
    gentle = replace(slope, unit=0.01)  # a centimetre per block: 5.7 degrees
    with pytest.raises(ParameterError, match=r"at the best place it tilts by 5\.\d+ degrees"):
        spots_of(gentle, body("jackal"), 1, 1)
    (spot,) = find_spots(gentle, body("jackal"), 1, np.random.default_rng(1), most_tilt=radians(8))
    assert 4 < degrees(spot.tilt) < 8


@pytest.mark.parametrize(
    ("field", "count", "message"),
    [
        (flat(1), 1, "robot: too large for 1 x 1 cells; use a smaller robot or a larger map"),
        (flat(6), 30, "count: found spots for .* of 30 on this map; use fewer, or add a platform obstacle"),
    ],
)
def test_too_large_or_too_many_values_are_refused(field: StepField, count: int, message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        spots_of(field, body("burger"), count, 1, gap=0.1)


def test_a_robot_fits_only_where_all_of_it_is_on_the_map() -> None:
    assert fits(flat(3), body("burger"))
    assert not fits(flat(5), body("crawler"))


@pytest.mark.parametrize(("length", "width"), [(100, 100), (100, 0.3), (2.9, 0.1), (1.5, 2.7)])
def test_a_robot_that_is_larger_than_the_map_is_refused_without_much_memory(length: float, width: float) -> None:
    tracemalloc.start()
    with pytest.raises(ParameterError, match="too large for 20 x 20 cells"):
        spots_of(flat(), body_of_size(length, width), 1, 1)
    taken = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert taken < 200_000_000


def test_a_box_of_a_size_lies_on_the_ground() -> None:
    (spot,) = spots_of(flat(), body_of_size(0.3, 0.2), 1, 1)
    assert [spot.z, spot.tilt] == pytest.approx([0, 0], abs=1e-6)
    assert Outline.of(body_of_size(0.3, 0.2)) == pytest.approx((-0.15, -0.1, 0.15, 0.1))


@pytest.mark.slow
def test_a_large_map_costs_no_more_than_a_small_one() -> None:
    field, before = rough(1, blocks=600), time.process_time()
    assert spots_of(field, body("jackal"), 1, 1)
    assert time.process_time() - before < 3
