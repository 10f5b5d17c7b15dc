"""What one robot can do on a field: analogues of NIST's coverability and crossability, whose formulas they are not."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rsegen.field.metrics.ground import ground, lane
from rsegen.field.metrics.regions import mutual
from rsegen.field.metrics.steps import steps
from rsegen.field.metrics.ways import FAR, ways
from rsegen.field.robot_limits import NANOMETRES, RobotLimits
from rsegen.field.stepfield import Array, Ints, Mask, StepField


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Crossing:
    """The cheapest way from the level ground on one side to that on the other; None where there is no way.

    length: of its plan   cost: length + every rise and drop on it, metres   ratios: to the straight and level way
    path: (n, 2), its cells i, j; those on the ground lie outside the field   costs: (n_x, n_y), to there, inf if never
    """

    crosses: bool
    length: float | None
    length_ratio: float | None
    cost: float | None
    cost_ratio: float | None
    path: Ints
    costs: Array

    def __post_init__(self) -> None:
        for array in (self.path, self.costs):
            array.setflags(write=False)


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Reach:
    """What a robot can do.

    climbable, droppable: share of the steps between blocks that it gets up, and down; None where there are none
    cover: share of the blocks in the largest region in which it gets from each to each; region: (n_x, n_y), their cells
    """

    climber: RobotLimits
    climbable: float | None
    droppable: float | None
    cover: float
    west_east: Crossing
    south_north: Crossing
    region: Mask

    def __post_init__(self) -> None:
        self.region.setflags(write=False)


def reach(field: StepField, climber: RobotLimits) -> Reach:
    """What a robot can do on a field, of which the frames count: they are in its way, though not where it stays."""
    climbable, droppable = (_share_within(field, limit / NANOMETRES) for limit in climber.limits)
    region = _largest_region(field, climber)
    return Reach(
        climber=climber,
        climbable=climbable,
        droppable=droppable,
        cover=float(region.sum() / (~field.frame).sum()),
        west_east=crossing(field, climber, 0),
        south_north=crossing(field, climber, 1),
        region=region,
    )


def _share_within(field: StepField, limit: float) -> float | None:
    above = steps(field).share_above(limit)
    return None if above is None else 1 - above


def _largest_region(field: StepField, climber: RobotLimits) -> Mask:
    """The blocks of the strongly connected component that has most of them; of two as large, of the first."""
    carrying = ground(field, climber.width)
    (low, high), (climb, drop) = carrying.moves(), climber.limits
    rise = carrying.heights.flat[high] - carrying.heights.flat[low]
    onward, back = (rise <= climb) & (-rise <= drop), (-rise <= climb) & (rise <= drop)
    group = mutual(field.levels.size, low, high, onward, back).reshape(field.shape)
    return np.asarray(~field.frame & (group == np.bincount(group[~field.frame]).argmax()))


def crossing(field: StepField, climber: RobotLimits, axis: int) -> Crossing:
    """Along x for axis 0, along y for axis 1, which is then the first one until the end."""
    carrying = lane(field, climber.width, axis)
    found = ways(carrying, round(field.block_width * NANOMETRES), climber.limits)
    margin = (len(found.costs) - field.shape[axis]) // 2
    costs = np.where(found.costs == FAR, np.inf, found.costs / NANOMETRES)[margin:-margin]
    costs = costs if axis == 0 else costs.T
    end = int(found.costs[-1].argmin())
    if (cost := int(found.costs[-1, end])) == FAR:
        return _no_crossing(costs)
    path = found.to(found.costs.size - found.costs.shape[1] + end) - (margin, 0)
    length, straight = ((cells - 1) * field.block_width for cells in (len(path), len(found.costs)))
    return Crossing(
        crosses=True,
        length=length,
        length_ratio=length / straight,
        cost=cost / NANOMETRES,
        cost_ratio=cost / NANOMETRES / straight,
        path=path if axis == 0 else path[:, ::-1],
        costs=costs,
    )


def _no_crossing(costs: Array) -> Crossing:
    none = np.empty((0, 2), dtype=np.int64)
    return Crossing(crosses=False, length=None, length_ratio=None, cost=None, cost_ratio=None, path=none, costs=costs)
