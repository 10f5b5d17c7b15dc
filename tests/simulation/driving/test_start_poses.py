"""Footprints of robots, and their start poses next to a map and on it."""

from __future__ import annotations

import numpy as np
import pytest

from rsegen import Random, Recipe, StepField, build, spots
from rsegen.errors import ParameterError
from rsegen.footprints.footprint import TOUCHING
from rsegen.robots import ROBOTS, Robot, SdfRobot
from rsegen.robots.footprint import footprint_of
from rsegen.simulation.driving.robot_runs import DROP_HEIGHT, GAP, adjacent_pose, finish_x, robot_runs

ROBOT = pytest.mark.parametrize("robot", ROBOTS.values(), ids=list(ROBOTS))
RECIPE = Recipe(chunk_size=20, boundary="none", unit_cm=1, seed=1, obstacles=(Random(levels=2),))


def flat(blocks: int) -> StepField:
    levels = np.zeros((blocks, blocks), dtype=np.int16)
    return StepField(levels=levels, frame=levels < 0, block_width=0.1, unit=0.1, frame_height=0.1)


def stairs() -> StepField:
    levels = (np.indices((12, 12)).sum(0) * 2).astype(np.int16)
    return StepField(levels=levels, frame=levels < 0, block_width=0.1, unit=0.1, frame_height=0.1)


@ROBOT
def test_the_footprint_is_as_large_as_the_robot_and_stands_on_the_ground(robot: Robot) -> None:
    found = footprint_of(robot)
    assert (found.outline.length, found.outline.width) == pytest.approx(robot.size[:2], abs=0.003)
    assert min(bottom for _, bottom in found.undersides) == pytest.approx(0, abs=TOUCHING)
    assert max(bottom for _, bottom in found.undersides) >= robot.clearance
    assert 0.003 < found.limit < 0.02


@pytest.mark.parametrize(("kind", "supports"), [("burger", 3), ("jackal", 4), ("crawler", 4)])
def test_a_robot_stands_on_its_wheels_and_caster(kind: str, supports: int) -> None:
    found = footprint_of(ROBOTS[kind])
    assert sum(bottom <= TOUCHING for _, bottom in found.undersides) == supports


def test_of_a_robot_from_a_file_only_the_size_is_known() -> None:
    robot = SdfRobot(kind="mine", text="<model/>", size=(0.4, 0.2, 0.1))
    (part,) = footprint_of(robot).undersides
    assert tuple(part.rectangle) == pytest.approx((-0.2, -0.1, 0.2, 0.1))
    assert part.bottom == 0


@ROBOT
def test_outside_the_map_the_whole_robot_is_on_the_ground(robot: Robot) -> None:
    field, footprint = flat(20), footprint_of(robot)
    place = adjacent_pose(field, footprint, 0.5)
    assert place.x + footprint.outline.high_x == pytest.approx(-1 - GAP)
    assert (place.y, place.z, place.yaw) == (0.5, DROP_HEIGHT, 0)
    assert finish_x(field, robot) + footprint.outline.low_x == pytest.approx(1)


def test_a_drive_starts_at_the_spots_of_its_seed() -> None:
    runs = robot_runs(build(RECIPE), ROBOTS["burger"], "random", count=3, seed=7)
    found = spots(RECIPE, robot="burger", count=3, seed=7)
    assert [(run.start.x, run.start.y, run.start.yaw) for run in runs] == [(spot.x, spot.y, spot.yaw) for spot in found]
    assert [run.start.z for run in runs] == pytest.approx([spot.z + DROP_HEIGHT for spot in found])
    assert {run.unevenness for run in runs} == {0}


def test_without_an_even_place_a_drive_is_refused_and_a_trial_gets_the_evenest() -> None:
    with pytest.raises(ParameterError, match="robot: no place is even enough"):
        robot_runs(stairs(), ROBOTS["burger"], "random", count=1, seed=1)
    runs = robot_runs(stairs(), ROBOTS["burger"], "random", count=2, seed=1, evenest=True)
    assert len(runs) == 2
    assert all(run.unevenness > 0.1 for run in runs)


def test_too_many_robots_are_refused_by_the_name_of_their_number() -> None:
    with pytest.raises(ParameterError, match="robots: found even places for 1 of 9 on this map; give fewer"):
        robot_runs(flat(3), ROBOTS["burger"], "random", count=9, seed=1)


def test_a_robot_larger_than_the_map_starts_next_to_it() -> None:
    (run,) = robot_runs(flat(3), ROBOTS["crawler"], "random", count=1, seed=1)
    assert run.start.x < -0.15
