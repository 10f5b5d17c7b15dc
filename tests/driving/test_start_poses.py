"""Bodies of robots, and their start poses next to a map and on it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rsegen import Random, Recipe, StepField, build, spots
from rsegen.driving.robot_runs import finish_x, robot_runs
from rsegen.errors import ParameterError
from rsegen.robots.base import ROBOTS, Robot
from rsegen.robots.files.sdf_file import SdfRobot
from rsegen.simulators.poses import DROP_HEIGHT, Pose, adjacent_pose
from rsegen.standing.outlines import Outline
from rsegen.standing.spots import GAP, find_spots, spot_generator

ROBOT = pytest.mark.parametrize("robot", ROBOTS.values(), ids=list(ROBOTS))
RECIPE = Recipe(chunk_size=20, boundary="none", unit_cm=1, seed=1, obstacles=(Random(levels=2),))


def flat(blocks: int) -> StepField:
    levels = np.zeros((blocks, blocks), dtype=np.int16)
    return StepField(levels=levels, frame=levels < 0, block_width=0.1, unit=0.1, frame_height=0.1)


def stairs() -> StepField:
    """Steps of 4 cm up along both x and y: a robot stands there, but nowhere level."""
    levels = (np.indices((12, 12)).sum(0) * 2).astype(np.int16)
    return StepField(levels=levels, frame=levels < 0, block_width=0.1, unit=0.02, frame_height=0.1)


@ROBOT
def test_the_body_is_as_large_as_the_robot_and_stands_on_the_ground(robot: Robot) -> None:
    outline = Outline.of(robot.body)
    assert (outline.length, outline.width) == pytest.approx(robot.size[:2], abs=0.04)  # without hubs
    assert float(robot.body.low[2]) == pytest.approx(0, abs=0.0005)


def test_a_robot_of_a_file_without_known_shapes_is_a_box_of_its_size() -> None:
    robot = SdfRobot(kind="mine", text="<model/>", size=(0.4, 0.2, 0.1))
    assert tuple(Outline.of(robot.body_or_box)) == pytest.approx((-0.2, -0.1, 0.2, 0.1))


@ROBOT
def test_outside_the_map_the_whole_robot_is_on_the_ground(robot: Robot) -> None:
    field, body = flat(20), robot.body
    place = adjacent_pose(field, body, 0.5)
    assert place.x + body.high[0] == pytest.approx(-1 - GAP)
    assert (place.y, place.z, place.yaw) == (0.5, DROP_HEIGHT, 0)
    assert finish_x(field, robot) + body.low[0] == pytest.approx(1)


def test_a_drive_starts_at_the_spots_of_its_seed() -> None:
    runs = robot_runs(build(RECIPE), ROBOTS["burger"], "random", count=3, seed=7)
    found = spots(RECIPE, robot="burger", count=3, seed=7)
    for run, spot in zip(runs, found, strict=True):
        assert replace(run.start, z=0) == Pose(x=spot.x, y=spot.y, z=0, roll=spot.roll, pitch=spot.pitch, yaw=spot.yaw)
        assert run.start.z == pytest.approx(spot.z + DROP_HEIGHT)


def test_without_a_spot_a_drive_is_refused_and_a_trial_gets_the_best_place() -> None:
    with pytest.raises(ParameterError, match="robot: no spot on this map"):
        robot_runs(stairs(), ROBOTS["burger"], "random", count=1, seed=1)
    runs = robot_runs(stairs(), ROBOTS["burger"], "random", count=2, seed=1, evenest=True)
    found = find_spots(stairs(), ROBOTS["burger"].body, 2, spot_generator(1), evenest=True)
    assert [run.start for run in runs] == [Pose.above(spot) for spot in found]
    assert all(spot.reason for spot in found)


def test_too_many_robots_are_refused_by_the_name_of_their_number() -> None:
    with pytest.raises(ParameterError, match=r"robots: found spots for . of 9 on this map; use fewer"):
        robot_runs(flat(3), ROBOTS["burger"], "random", count=9, seed=1)


def test_a_robot_larger_than_the_map_starts_next_to_it() -> None:
    (run,) = robot_runs(flat(3), ROBOTS["crawler"], "random", count=1, seed=1)
    assert run.start.x < -0.15
