"""Routes keep within a robot's speeds, come back to their line, and stay on the map."""

from __future__ import annotations

from collections.abc import Iterator
from math import cos, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rsegen.driving.routes import Route, Straight, Wandering
from rsegen.simulators.poses import Pose

PLACE = st.floats(-5, 5)
ANGLE = st.floats(-3.2, 3.2)


def wandering(seed: int = 1) -> Wandering:
    return Wandering(speed=0.4, turn=2.0, half=(0.8, 0.8), rng=np.random.default_rng(seed))


def followed(route: Route, at: Pose, turns: int) -> Iterator[Pose]:
    """End of an ideal robot's route on level ground."""
    for _ in range(turns):
        v, w = route.motion(at)
        step = route.period / 50
        for _ in range(50):
            at = Pose(x=at.x + v * cos(at.yaw) * step, y=at.y + v * sin(at.yaw) * step, z=0, yaw=at.yaw + w * step)
        yield at


@given(x=PLACE, y=PLACE, yaw=ANGLE)
def test_no_route_asks_for_more_than_the_robot_can(x: float, y: float, yaw: float) -> None:
    for route in (Straight(speed=0.4, turn=2.0, line=0.3, goal=9.0), wandering()):
        motion = route.motion(Pose(x=x, y=y, z=0, yaw=yaw))
        assert abs(motion.v) <= 0.4
        assert abs(motion.w) <= 2.0


@pytest.mark.parametrize("speed", [0.1, 0.22, 0.4, 1.0, 2.0])
@pytest.mark.parametrize("yaw", [-1.0, 0.5])
def test_a_straight_route_comes_back_to_its_line_without_weaving(speed: float, yaw: float) -> None:
    route = Straight(speed=speed, turn=2.0, line=0.5, goal=1e9)
    trajectory = list(followed(route, Pose(x=0, y=0, z=0, yaw=yaw), 200))
    assert max(abs(at.y - 0.5) for at in trajectory[-20:]) < 0.01
    assert max(abs(at.yaw) for at in trajectory[-20:]) < 0.01


def test_a_straight_route_ends_at_its_goal() -> None:
    route = Straight(speed=0.4, turn=2.0, line=0.0, goal=1.0)
    assert not route.is_done(Pose(x=0.99, y=0, z=0))
    assert route.is_done(Pose(x=1.0, y=0, z=0))
    assert route.motion(Pose(x=1.0, y=0, z=0)) == (0.0, 0.0)


def test_wandering_stays_about_its_rectangle_and_goes_all_over_it() -> None:
    trajectory = list(followed(wandering(), Pose(x=0, y=0, z=0), 300))
    assert max(max(abs(at.x), abs(at.y)) for at in trajectory) < 1.6
    assert len({(at.x > 0, at.y > 0) for at in trajectory}) == 4


def test_wandering_is_drawn_from_its_generator_alone() -> None:
    at = Pose(x=0.1, y=0.2, z=0)
    assert wandering(7).motion(at) == wandering(7).motion(at)
    assert wandering(7).motion(at) != wandering(8).motion(at)


def test_wandering_backs_away_from_where_it_does_not_come_on() -> None:
    route, here = wandering(), Pose(x=0, y=0, z=0)
    assert [route.motion(here).v > 0 for _ in range(3)] == [True, False, True]
