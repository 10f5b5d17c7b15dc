"""What robots did in a trial: how far they drove, how long they were stuck, what they have seen of the map."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import ceil
from statistics import fmean
from typing import NamedTuple

import numpy as np

from rsegen.field.stepfield import Array, StepField
from rsegen.simulation.driving.drive_metrics import Trajectory, drive_metrics
from rsegen.simulation.driving.recording import RobotRun
from rsegen.simulation.driving.robot_runs import driving_speed
from rsegen.simulation.robots.base import DrivableRobot
from rsegen.simulation.simulators.live_world import Record


class DrivingFigures(NamedTuple):
    """The means over the robots of a trial; None if nothing of them is known.

    driven: metres; stuck: share of the time, 0..1; tipped: how often each tipped over; covered: share of the cells of
    the map over which some part of a robot has been, 0..1, None in an empty world
    """

    driven: float | None
    stuck: float | None
    tipped: float | None
    covered: float | None


def trajectories(record: Record, runs: Sequence[RobotRun]) -> dict[str, Trajectory]:
    """The trajectories of robots that were in a record, by their names."""
    rows = {run.name: [[second, *poses[run.name]] for second, poses in record if run.name in poses] for run in runs}
    return {name: Trajectory(rows=np.array(each)) for name, each in rows.items() if each}


def driving_figures(
    found: Mapping[str, Trajectory], runs: Sequence[RobotRun], field: StepField | None
) -> DrivingFigures:
    """The figures of robots with these trajectories on a field, None for an empty world."""
    driven = [(found[run.name], run.robot) for run in runs if run.name in found]
    if not driven:
        return DrivingFigures(None, None, None, None)
    metrics = [drive_metrics(track, driving_speed(robot)) for track, robot in driven]
    return DrivingFigures(
        driven=round(fmean(one.distance for one in metrics), 3),
        stuck=round(fmean(one.stuck / max(one.seconds, 1.0) for one in metrics), 4),
        tipped=round(fmean(one.tipped for one in metrics), 3),
        covered=round(fmean(covered(track, robot, field) for track, robot in driven), 5) if field else None,
    )


def covered(track: Trajectory, robot: DrivableRobot, field: StepField) -> float:
    """The share of a field's cells over which some part of a robot's footprint has been, 0..1.

    The footprint is the rectangle of its length and width; it is there at points half a block apart or less, at every
    row of its trajectory.
    """
    points = _footprint(robot, field.block_width / 2)
    x, y, yaw = (track.rows[:, [column]] for column in (1, 2, 6))
    along, across = points[:, 0], points[:, 1]
    places = [x + np.cos(yaw) * along - np.sin(yaw) * across, y + np.sin(yaw) * along + np.cos(yaw) * across]
    i, j = (
        np.floor((place + extent / 2) / field.block_width).astype(int).ravel()
        for place, extent in zip(places, field.extent, strict=True)
    )
    been = np.zeros(field.shape, dtype=bool)
    on_it = (i >= 0) & (j >= 0) & (i < field.shape[0]) & (j < field.shape[1])
    been[i[on_it], j[on_it]] = True
    return float(been.mean())


def _footprint(robot: DrivableRobot, apart: float) -> Array:
    """Points of a robot's length and width about its origin, this far apart or less, shape (n, 2)."""
    axes = [np.linspace(-side / 2, side / 2, ceil(side / apart) + 1) for side in robot.size[:2]]
    return np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
