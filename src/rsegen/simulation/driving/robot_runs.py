"""The runs of robots of one kind: safe start poses on or next to a map, and a route for each.

A start pose is level and never inside a block: on the ground west of the map, or on one of its even spots, from which
the robot falls by 5 mm. The same seed gives the same spots and routes; `rsegen spots` shows them (docs/driving.md).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from rsegen.errors import ParameterError, UnknownName
from rsegen.field.stepfield import StepField
from rsegen.footprints import Footprint, Spot, even_spots, fits
from rsegen.params.streams import generator
from rsegen.robots.base import DrivableRobot, Robot
from rsegen.robots.footprint import footprint_of
from rsegen.simulation.driving.recording import RobotRun
from rsegen.simulation.driving.routes import AlongWay, PlannedWay, Route, Straight, Wandering, planned_way
from rsegen.simulation.simulators.live_world import Pose

GAP = 0.1
"""Gap, metres, between a robot and the map next to it, and between two robots: more than they drift on the way."""

DROP_HEIGHT = 0.005
"""Height, metres, above the ground at which robots start, so that they do not start inside it.

It is beyond contacts' penetration, some 1 mm for soft wheels; a longer fall would shake the robot.
"""


def adjacent_pose(field: StepField, footprint: Footprint, aside: float = 0.0) -> Pose:
    """Return the pose on the ground west of the map, heading east, `aside` metres north of its centre line."""
    return Pose(x=-field.extent[0] / 2 - GAP - footprint.outline.high_x, y=aside, z=DROP_HEIGHT)


def spots_on_map(
    field: StepField, footprint: Footprint, count: int, rng: np.random.Generator, *, evenest: bool = False
) -> tuple[Spot, ...]:
    """Places for robots on a map, on which they stand level and do not overlap; ParameterError if there are too few.

    evenest: where no place is level, take the one with the least unevenness.
    """
    return even_spots(field, footprint, count, rng, gap=GAP, evenest=evenest)


def start_pose(spot: Spot) -> Pose:
    """Return the pose from which a robot falls onto a spot: no part of it is inside a block."""
    return Pose(x=spot.x, y=spot.y, z=spot.z + DROP_HEIGHT, yaw=spot.yaw)


MAX_DRIVING_SPEED = 0.4
"""Speed, m/s, at which faster robots drive on rough ground: tracked ones climb stairs of 10 and 20 cm with it.

Faster, a robot leaves the ground at edges, and what it meets depends on its springs, which these models do not have.
"""

ROUTES = (Straight.name, Wandering.name, AlongWay.name)


def robot_runs(  # the last three by name
    field: StepField, robot: DrivableRobot, route: str, *, count: int, seed: int, evenest: bool = False
) -> Sequence[RobotRun]:
    """Return the runs of `count` robots on a route.

    For a straight crossing they start side by side west of the map, along the way that the metrics find one behind the
    other, else on the map where they stand level, or west of it if they are larger than it. ParameterError if there are
    too few level places; with `evenest` they start at the least uneven ones, and the runs have their unevenness.
    """
    if route not in ROUTES:
        raise UnknownName.among("route", "route", route, ROUTES)
    if route == Straight.name:
        return _side_by_side(field, robot, count)
    if route == AlongWay.name:
        return _one_behind_the_other(field, robot, count)
    return _randomly_placed(field, robot, count, seed, evenest=evenest)


def finish_x(field: StepField, robot: DrivableRobot) -> float:
    """Return the x of a robot's centre beyond which the whole robot is east of the map, metres."""
    return field.extent[0] / 2 - footprint_of(robot).outline.low_x


def _side_by_side(field: StepField, robot: DrivableRobot, count: int) -> list[RobotRun]:
    footprint = footprint_of(robot)
    lane = footprint.outline.width + GAP
    lines = [(index - (count - 1) / 2) * lane for index in range(count)]
    goal = finish_x(field, robot) + GAP
    return [
        RobotRun(
            name=_name(robot, index),
            robot=robot,
            start=adjacent_pose(field, footprint, line),
            route=partial(_straight, robot, line, goal),
        )
        for index, line in enumerate(lines)
    ]


def _straight(robot: DrivableRobot, line: float, goal: float) -> Route:
    return Straight(speed=driving_speed(robot), turn=robot.turn, line=line, goal=goal)


def _one_behind_the_other(field: StepField, robot: DrivableRobot, count: int) -> list[RobotRun]:
    limits = robot.limits if isinstance(robot, Robot) else None
    way, footprint = planned_way(field, robot.size[1], limits), footprint_of(robot)
    first = adjacent_pose(field, footprint, float(way.points[0, 1]))
    return [
        RobotRun(
            name=_name(robot, index),
            robot=robot,
            start=replace(first, x=first.x - index * (footprint.outline.length + GAP)),
            route=partial(_along, field, robot, way),
            way=way,
        )
        for index in range(count)
    ]


def _along(field: StepField, robot: DrivableRobot, way: PlannedWay) -> Route:
    """Return the route along a way, and straight on from its end until the whole robot is beyond the map."""
    ahead, goal = max(field.block_width, robot.size[0] / 2), finish_x(field, robot) + GAP
    points = [(x, y) for x, y in way.points.tolist()]
    points.append((goal + ahead, points[-1][1]))
    return AlongWay(speed=driving_speed(robot), turn=robot.turn, points=points, ahead=ahead, goal=goal)


def driving_speed(robot: DrivableRobot) -> float:
    """Return the commanded speed of a robot, m/s."""
    return min(robot.speed, MAX_DRIVING_SPEED)


def _randomly_placed(field: StepField, robot: DrivableRobot, count: int, seed: int, *, evenest: bool) -> list[RobotRun]:
    """Return runs on the map if a robot fits there, else in a row west of it."""
    footprint = footprint_of(robot)
    if fits(field, footprint):  # a command knows `robots`, not `count`
        try:
            spots = spots_on_map(field, footprint, count, spot_generator(seed), evenest=evenest)
        except ParameterError as error:
            raise ParameterError("robots" if error.where == "count" else error.where, error.problem) from None
        starts = [(start_pose(spot), spot.unevenness) for spot in spots]
    else:
        starts = [(run.start, 0.0) for run in _side_by_side(field, robot, count)]
    return [
        RobotRun(
            name=_name(robot, index),
            robot=robot,
            start=start,
            route=partial(_random, field, robot, seed, index),
            unevenness=unevenness,
        )
        for index, (start, unevenness) in enumerate(starts)
    ]


def spot_generator(seed: int) -> np.random.Generator:
    """Return the generator of the places of robots: `rsegen spots` gives those at which `rsegen drive` starts."""
    return generator(seed, 0, "places")


def _random(field: StepField, robot: DrivableRobot, seed: int, index: int) -> Route:
    reach = max(robot.size[:2])
    half_x, half_y = (max(along / 2 - reach, 0.0) for along in field.extent)
    rng = generator(seed, index, "route")
    return Wandering(speed=driving_speed(robot), turn=robot.turn, half=(half_x, half_y), rng=rng)


def _name(robot: DrivableRobot, index: int) -> str:
    return f"{robot.kind}_{index}"
