"""The runs of robots of one kind: safe start poses on or next to a map, and a route for each."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from rsegen.errors import UnknownName
from rsegen.field.stepfield import StepField
from rsegen.params.streams import generator
from rsegen.simulation.driving.recording import RobotRun
from rsegen.simulation.driving.routes import Route, Straight, Wandering
from rsegen.simulation.driving.start_poses import GAP, adjacent_pose, fits_on_map, poses_on_map
from rsegen.simulation.robots.base import DrivableRobot
from rsegen.simulation.simulators.live_world import Pose

MAX_DRIVING_SPEED = 0.4
"""Metres per second: faster robots are slowed down to this on rough ground."""

ROUTES = (Straight.name, Wandering.name)


def robot_runs(field: StepField, robot: DrivableRobot, route: str, *, count: int, seed: int) -> Sequence[RobotRun]:
    """The runs of `count` robots: side by side west of the map for a straight crossing, else randomly on the map."""
    if route not in ROUTES:
        raise UnknownName.among("route", "route", route, ROUTES)
    return _side_by_side(field, robot, count) if route == Straight.name else _randomly_placed(field, robot, count, seed)


def finish_x(field: StepField, robot: DrivableRobot) -> float:
    """The x of a robot's centre beyond which the whole robot is east of the map, metres."""
    return field.extent[0] / 2 + robot.size[0] / 2


def _side_by_side(field: StepField, robot: DrivableRobot, count: int) -> list[RobotRun]:
    lane = robot.size[1] + GAP
    lines = [(number - (count - 1) / 2) * lane for number in range(count)]
    goal = finish_x(field, robot) + GAP
    return [
        RobotRun(
            name=_name(robot, number),
            robot=robot,
            start=adjacent_pose(field, robot.size, line),
            route=partial(_straight, robot, line, goal),
        )
        for number, line in enumerate(lines)
    ]


def _straight(robot: DrivableRobot, line: float, goal: float) -> Route:
    return Straight(speed=driving_speed(robot), turn=robot.turn, line=line, goal=goal)


def driving_speed(robot: DrivableRobot) -> float:
    """The commanded speed of a robot, m/s."""
    return min(robot.speed, MAX_DRIVING_SPEED)


def _randomly_placed(field: StepField, robot: DrivableRobot, count: int, seed: int) -> list[RobotRun]:
    places = _places(field, robot, count, seed)
    return [
        RobotRun(
            name=_name(robot, number), robot=robot, start=place, route=partial(_random, field, robot, seed, number)
        )
        for number, place in enumerate(places)
    ]


def _places(field: StepField, robot: DrivableRobot, count: int, seed: int) -> list[Pose]:
    """On the map if a robot fits there, else in a row west of it."""
    if fits_on_map(field, robot.size):
        return poses_on_map(field, [robot.size] * count, generator(seed, 0, "places"))
    return [run.start for run in _side_by_side(field, robot, count)]


def _random(field: StepField, robot: DrivableRobot, seed: int, number: int) -> Route:
    reach = max(robot.size[:2])
    half_x, half_y = (max(along / 2 - reach, 0.0) for along in field.extent)
    rng = generator(seed, number, "route")
    return Wandering(speed=driving_speed(robot), turn=robot.turn, half=(half_x, half_y), rng=rng)


def _name(robot: DrivableRobot, number: int) -> str:
    return f"{robot.kind}_{number}"
