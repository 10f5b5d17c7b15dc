"""Who drives where: robots of one kind, at safe places of a map, each on a route of its own."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from rsegen.errors import UnknownName
from rsegen.field.stepfield import StepField
from rsegen.params.streams import generator
from rsegen.simulation.driving.drive import RobotRun
from rsegen.simulation.driving.routes import Route, Straight, Wandering
from rsegen.simulation.driving.start_poses import GAP, adjacent_pose, fits_on_map, poses_on_map
from rsegen.simulation.robots.base import DrivableRobot
from rsegen.simulation.simulators.live_world import Pose

MAX_DRIVING_SPEED = 0.4
"""Metres a second: a robot that could go faster takes its time on rough ground."""

ROUTES = (Straight.name, Wandering.name)


def robot_runs(field: StepField, robot: DrivableRobot, route: str, *, count: int, seed: int) -> Sequence[RobotRun]:
    """So many robots of a kind: side by side before a straight crossing, else on top of the map, to wander about."""
    if route not in ROUTES:
        raise UnknownName.among("route", "route", route, ROUTES)
    return _abreast(field, robot, count) if route == Straight.name else _scattered(field, robot, count, seed)


def finish_x(field: StepField, robot: DrivableRobot) -> float:
    """The x of a robot's middle from which on the whole of it is east of the map, metres."""
    return field.extent[0] / 2 + robot.size[0] / 2


def _abreast(field: StepField, robot: DrivableRobot, count: int) -> list[RobotRun]:
    lane = robot.size[1] + GAP
    lines = [(number - (count - 1) / 2) * lane for number in range(count)]
    goal = finish_x(field, robot) + GAP
    return [
        RobotRun(
            name=_name(robot, number),
            robot=robot,
            start=adjacent_pose(field, robot.size, line),
            route=partial(_along, robot, line, goal),
        )
        for number, line in enumerate(lines)
    ]


def _along(robot: DrivableRobot, line: float, goal: float) -> Route:
    return Straight(speed=driving_speed(robot), turn=robot.turn, line=line, goal=goal)


def driving_speed(robot: DrivableRobot) -> float:
    """The speed that a robot goes at, m/s."""
    return min(robot.speed, MAX_DRIVING_SPEED)


def _scattered(field: StepField, robot: DrivableRobot, count: int, seed: int) -> list[RobotRun]:
    places = _places(field, robot, count, seed)
    return [
        RobotRun(name=_name(robot, number), robot=robot, start=place, route=partial(_about, field, robot, seed, number))
        for number, place in enumerate(places)
    ]


def _places(field: StepField, robot: DrivableRobot, count: int, seed: int) -> list[Pose]:
    """On top of the map where a robot has room there, else in a row beside it."""
    if fits_on_map(field, robot.size):
        return poses_on_map(field, [robot.size] * count, generator(seed, 0, "places"))
    return [run.start for run in _abreast(field, robot, count)]


def _about(field: StepField, robot: DrivableRobot, seed: int, number: int) -> Route:
    reach = max(robot.size[:2])
    half_x, half_y = (max(along / 2 - reach, 0.0) for along in field.extent)
    rng = generator(seed, number, "route")
    return Wandering(speed=driving_speed(robot), turn=robot.turn, half=(half_x, half_y), rng=rng)


def _name(robot: DrivableRobot, number: int) -> str:
    return f"{robot.kind}_{number}"
