"""The step at which a field opens: what a robot has to climb at the least to cross it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rsegen.field.metrics.ground import Ground, lane
from rsegen.field.metrics.regions import joined
from rsegen.field.robot_limits import NANOMETRES
from rsegen.field.stepfield import StepField


@dataclass(frozen=True, kw_only=True, slots=True)
class Opening:
    """The minimax step, metres: over all ways from side to side the least of their highest steps, up or down."""

    west_east: float
    south_north: float


def opening(field: StepField, width: float = 0.0) -> Opening:
    """Where a field opens for robots of a width in metres, from the level ground on one side to that on the other."""
    west_east, south_north = (_minimax(lane(field, width, axis)) / NANOMETRES for axis in (0, 1))
    return Opening(west_east=west_east, south_north=south_north)


def _minimax(ground: Ground) -> int:
    """By halving the steps that there are: what too low a step joins stays joined, what is too high goes."""
    heights, (low, high) = ground.heights, ground.moves()
    steps = np.abs(heights.flat[high] - heights.flat[low])
    first, last, limits = 0, heights.size - 1, np.unique(steps)
    while len(limits) > 1:
        limit = limits[(len(limits) - 1) // 2]
        root = joined(heights.size, low[steps <= limit], high[steps <= limit])
        opens = root[first] == root[last]
        limits = limits[limits <= limit] if opens else limits[limits > limit]
        if not opens:
            low, high, first, last = root[low], root[high], root[first], root[last]
        left = steps <= limit if opens else low != high
        low, high, steps = low[left], high[left], steps[left]
    return int(limits[0])
