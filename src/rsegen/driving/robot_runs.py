"""The runs of robots of one kind: safe start poses on or next to a map, and a route for each.

A start pose is 5 mm above a robot at rest, so that no part is inside a block: on the ground west of the map, or at one
of its spots. The same seed gives the same spots and routes; `rsegen spots` shows them (docs/driving.md).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from math import ceil

import numpy as np

from rsegen.driving.parameters import ROUTES
from rsegen.driving.recording import RobotRun
from rsegen.driving.routes import AlongWay, PlannedWay, Route, Straight, Wandering, planned_way
from rsegen.errors import ParameterError, UnknownName
from rsegen.field.stepfield import StepField
from rsegen.params.streams import generator
from rsegen.robots.lookup import DrivableRobot
from rsegen.simulators.poses import Pose, adjacent_pose
from rsegen.standing.outlines import Outline, Spot, fits
from rsegen.standing.spots import GAP, find_spots, spot_generator

_POINTS = 8
"""Points of a way per distance `ahead` at which a robot heads for one of them."""


def robot_runs(  # noqa: PLR0913  # the last four by name
    field: StepField,
    robot: DrivableRobot,
    route: str,
    *,
    count: int,
    seed: int,
    best: str = "length",
    evenest: bool = False,
) -> Sequence[RobotRun]:
    """Return the runs of `count` robots on a route.

    Straight across they start side by side west of the map; along a planned way, of the criterion `best`, one behind
    the other; on a random route at spots on the map, or west of it if a robot is larger than the map. ParameterError if
    there are too few spots, unless `evenest` allows other places where a robot stands.
    """
    if route not in ROUTES:
        raise UnknownName.among("route", "route", route, ROUTES)
    if route == AlongWay.name:
        return runs_along(field, robot, planned_way(field, robot.body, best), count)
    body, goal = robot.body_or_box, finish_x(field, robot) + GAP
    lane = Outline.of(body).width + GAP
    starts = [adjacent_pose(field, body, (index - (count - 1) / 2) * lane) for index in range(count)]
    if route == Straight.name:
        straight = partial(Straight, speed=robot.driving_speed, turn=robot.turn, goal=goal)
        return _named(robot, starts, [partial(straight, line=at.y) for at in starts])
    places: Sequence[Spot | None] = [None] * count
    if fits(field, body):  # a command knows `robots`, not `count`
        try:
            places = find_spots(field, body, count, spot_generator(seed), evenest=evenest)
        except ParameterError as error:
            raise type(error)("robots" if error.where == "count" else error.where, error.problem) from None
    starts = [Pose.above(spot) if spot else at for spot, at in zip(places, starts, strict=True)]
    return _named(robot, starts, [partial(_random, field, robot, seed, index) for index in range(count)])


def runs_along(field: StepField, robot: DrivableRobot, way: PlannedWay, count: int = 1) -> Sequence[RobotRun]:
    """Return the runs of `count` robots along a way, which start one behind the other, and stop so beyond the map."""
    first = adjacent_pose(field, robot.body, float(way.points[0, 1]))
    apart = robot.body.length + GAP
    starts = [replace(first, x=first.x - index * apart) for index in range(count)]
    routes = [partial(_along, field, robot, way, (count - 1 - index) * apart) for index in range(count)]
    return [replace(run, way=way) for run in _named(robot, starts, routes)]


def finish_x(field: StepField, robot: DrivableRobot) -> float:
    """Return the x of a robot's centre beyond which the whole robot is east of the map, metres."""
    return field.extent[0] / 2 - float(robot.body_or_box.low[0])


def _along(field: StepField, robot: DrivableRobot, way: PlannedWay, beyond: float) -> Route:
    """Return the route along a way, and straight on until the whole robot is some metres `beyond` the map."""
    ahead, goal = max(field.block_width, robot.size[0] / 2), finish_x(field, robot) + GAP + beyond
    points = np.append(way.points, [(goal + ahead, way.points[-1, 1])], axis=0)
    # Points are that close together that the nearest one is always beside the robot.
    run = np.append(0.0, np.hypot(*np.diff(points, axis=0).T).cumsum())
    at = np.linspace(0.0, run[-1], ceil(run[-1] / ahead * _POINTS) + 1)
    dense = zip(*(np.interp(at, run, column).tolist() for column in points.T), strict=True)
    return AlongWay(speed=robot.driving_speed, turn=robot.turn, points=tuple(dense), ahead=ahead, goal=goal)


def _random(field: StepField, robot: DrivableRobot, seed: int, index: int) -> Route:
    clearance = max(robot.size[:2])
    half_x, half_y = (max(along / 2 - clearance, 0.0) for along in field.extent)
    rng = generator(seed, index, "route")
    return Wandering(speed=robot.driving_speed, turn=robot.turn, half=(half_x, half_y), rng=rng)


def _named(robot: DrivableRobot, starts: Sequence[Pose], routes: Sequence[Callable[[], Route]]) -> list[RobotRun]:
    """Return the runs of a robot at these poses, with a name each."""
    return [
        RobotRun(name=f"{robot.kind}_{index}", robot=robot, start=start, route=route)
        for index, (start, route) in enumerate(zip(starts, routes, strict=True))
    ]
