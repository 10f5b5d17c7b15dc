"""Lowers blocks so that a robot can cross a map from west to east and from south to north."""

from __future__ import annotations

import numpy as np

from rsegen.field.metrics.ground import lane
from rsegen.field.metrics.percolation import percolation_step
from rsegen.field.metrics.traversability import crossing
from rsegen.field.robot_limits import NANOMETRES, RobotLimits, cells_to_each_side
from rsegen.field.stepfield import Ints, StepField

_ANYTHING = 2**30


def crossing_caps(field: StepField, climber: RobotLimits) -> Ints | None:
    """The highest levels along a path on which the robot can cross; None if it can cross both ways already."""
    for axis in (0, 1):
        step = percolation_step(field, climber.width, axis)
        if not _crosses(field, climber, axis, step):
            return _along(field, climber, axis, step)
    return None


def _crosses(field: StepField, climber: RobotLimits, axis: int, step: float) -> bool:
    """Whether the robot can cross; only between its two limits must a path be searched to know it."""
    least, most = sorted(climber.limits)
    needed = round(step * NANOMETRES)
    return needed <= least or (needed <= most and crossing(field, climber, axis).crosses)


def _along(field: StepField, climber: RobotLimits, axis: int, step: float) -> Ints:
    """The highest levels along the cheapest of the paths whose highest step is `step`, the least that there is."""
    path = crossing(
        field, RobotLimits.of(step, climber.width), axis, shortest=False
    ).path  # any of the cheapest: another would be another map
    aside = cells_to_each_side(field, climber.width)
    found = np.full(field.shape, _ANYTHING)
    for (i, j), top in zip(path, _tops(field, climber, axis, path), strict=True):
        under = slice(max(i - aside, 0), max(i + aside + 1, 0)), slice(max(j - aside, 0), max(j + aside + 1, 0))
        found[under] = np.minimum(found[under], top)
    return found


def _tops(field: StepField, climber: RobotLimits, axis: int, path: Ints) -> Ints:
    """The highest level below the robot at each cell of its path, such that it can go on from there."""
    margin = cells_to_each_side(field, climber.width) + 1
    along = (path if axis == 0 else path[:, ::-1]) + (margin, 0)
    tops = lane(field, climber.width, axis).heights[along[:, 0], along[:, 1]]
    unit = round(field.unit * NANOMETRES)
    climb, drop = (0 if limit < unit else limit for limit in climber.limits)  # less than a block is no step at all
    for k in range(1, len(tops)):
        tops[k] = min(tops[k], tops[k - 1] + climb)
    for k in range(len(tops) - 2, -1, -1):
        tops[k] = min(tops[k], tops[k + 1] + drop)
    return np.asarray(tops // unit)
