"""The percolation step: the smallest step that a robot must be able to climb to cross a field."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rsegen.field.metrics.ground import Ground, lane
from rsegen.field.metrics.regions import connected
from rsegen.field.robot_limits import NANOMETRES
from rsegen.field.stepfield import StepField


@dataclass(frozen=True, kw_only=True, slots=True)
class Percolation:
    """The percolation step in metres: over all paths from side to side, the smallest of their highest steps."""

    west_east: float
    south_north: float


def percolation(field: StepField, width: float = 0.0) -> Percolation:
    """The percolation step for robots of a width in metres, from the ground on one side to that on the other."""
    west_east, south_north = (percolation_step(field, width, axis) for axis in (0, 1))
    return Percolation(west_east=west_east, south_north=south_north)


def percolation_step(field: StepField, width: float, axis: int) -> float:
    """The percolation step in metres along x for axis 0, along y for axis 1."""
    return _minimax(lane(field, width, axis)) / NANOMETRES


def _minimax(ground: Ground) -> int:
    """The smallest step that connects both sides, by bisection over the steps of the field with union of components."""
    heights, (low, high) = ground.heights, ground.moves()
    steps = np.abs(heights.flat[high] - heights.flat[low])
    first, last, limits = 0, heights.size - 1, np.unique(steps)
    while len(limits) > 1:
        limit = limits[(len(limits) - 1) // 2]
        root = connected(heights.size, low[steps <= limit], high[steps <= limit])
        opens = root[first] == root[last]
        limits = limits[limits <= limit] if opens else limits[limits > limit]
        if not opens:
            low, high, first, last = root[low], root[high], root[first], root[last]
        left = steps <= limit if opens else low != high
        low, high, steps = low[left], high[left], steps[left]
    return int(limits[0])
