"""The planned way is followed by a point robot, but for its corners, and as far as the goal."""

from __future__ import annotations

from itertools import pairwise
from math import cos, inf, sin

import numpy as np
import pytest

import rsegen
from rsegen.driving.robot_runs import finish_x, robot_runs
from rsegen.driving.routes import Route, planned_way
from rsegen.field.stepfield import StepField
from rsegen.recipe.examples import EXAMPLES
from rsegen.robots.base import ROBOTS
from rsegen.robots.lookup import robot_of_kind
from rsegen.simulators.poses import Pose

STEP = 0.05
"""Seconds."""


def followed(route: Route, start: Pose, seconds: float) -> list[tuple[float, float]]:
    """The places of a point that does what the route says."""
    x, y, yaw, places = start.x, start.y, start.yaw, [(start.x, start.y)]
    for turn in range(round(seconds / STEP)):
        if turn % round(route.period / STEP) == 0:
            at = Pose(x=x, y=y, z=0, yaw=yaw)
            if route.is_done(at):
                return places
            v, w = route.motion(at)
        x, y, yaw = x + v * STEP * cos(yaw), y + v * STEP * sin(yaw), yaw + w * STEP
        places.append((x, y))
    raise AssertionError(f"not at the goal but at {x}, {y}")


def off_line(place: tuple[float, float], points: np.ndarray) -> float:
    """Distance of a place from a line of points, metres."""
    least = inf
    for one, other in pairwise(points):
        along = other - one
        share = np.clip(np.dot(place - one, along) / np.dot(along, along), 0, 1)
        least = min(least, float(np.hypot(*(one + share * along - place))))
    return least


BENT = {
    "burger": rsegen.Recipe(seed=2, unit_cm=0.4, boundary="none", chunk_size=8, obstacles=(rsegen.Random(levels=4),)),
    "jackal": rsegen.Recipe(seed=8, unit_cm=3.5, boundary="none", chunk_size=8, obstacles=(rsegen.Random(levels=4),)),
    "crawler": rsegen.load(EXAMPLES["figure-7"]),
}
"""Kind of robot -> a map on which its way has bends."""


@pytest.mark.slow
@pytest.mark.parametrize("kind", BENT)
def test_a_robot_stays_on_its_way(kind: str) -> None:
    field = rsegen.build(BENT[kind])
    first, second = robot_runs(field, robot_of_kind(kind), "way", count=2, seed=1)
    assert first.way is not None
    assert first.way.crosses
    assert np.ptp(first.way.points[:, 1]) > field.block_width / 2, "it is straight"
    assert second.start.x < first.start.x - robot_of_kind(kind).size[0]
    places = followed(first.route(), first.start, 600)
    inside = [place for place in places if abs(place[0]) < field.extent[0] / 2]
    # Who heads for a point ahead, half a robot's length away, cuts corners by up to a quarter of that.
    cut = max(field.block_width / 2, robot_of_kind(kind).size[0] / 8)
    assert max(off_line(place, first.way.points) for place in inside[::10]) < cut
    assert places[-1][0] >= finish_x(field, robot_of_kind(kind))


def test_robots_stop_one_behind_the_other_and_all_beyond_the_map() -> None:
    field, robot = walled(gap=True), ROBOTS["burger"]
    runs = robot_runs(field, robot, "way", count=3, seed=1)
    goals = [run.route().goal for run in runs]
    assert goals[-1] > finish_x(field, robot)
    assert all(ahead - behind > robot.size[0] for ahead, behind in pairwise(goals))
    (alone,) = robot_runs(field, robot, "way", count=1, seed=1)
    assert alone.route().goal == goals[-1]


def test_a_way_avoids_steps_that_the_robot_cannot_climb() -> None:
    field, body = walled(gap=True), ROBOTS["burger"].body
    way = planned_way(field, body)
    assert way.crosses
    assert way.length == pytest.approx(2.0, abs=0.3)
    through = way.points[np.abs(way.points[:, 0]) < field.block_width]
    assert (through[:, 1] > 0.6).all()


@pytest.mark.slow
def test_without_a_way_the_lane_that_gets_farthest_is_taken_and_the_reason_is_told() -> None:
    field = walled(gap=False)
    way = planned_way(field, ROBOTS["burger"].body)
    assert not way.crosses
    assert way.at is not None
    assert way.at[0] == pytest.approx(-0.1, abs=0.1)
    assert (way.points[:, 1] == way.points[0, 1]).all()
    assert way.points[0, 1] == pytest.approx(way.at[1], abs=0.01)
    assert way.as_json() == {"crosses": False, "reason": way.reason, "at": way.at}
    assert "".join(way.csv()).startswith("x,y\n")


def walled(*, gap: bool) -> StepField:
    """A plain of 1.8 m with a wall of 10 cm across its middle, and perhaps a gap of 40 cm at its north end."""
    levels = np.zeros((18, 18), dtype=np.int16)
    levels[8:10] = 1
    if gap:
        levels[:, 14:] = 0
    return StepField(
        levels=levels, frame=np.zeros(levels.shape, dtype=bool), block_width=0.1, unit=0.1, frame_height=0.1
    )
