"""Traversability for one robot: analogous to NIST's coverability and crossability, by formulas of our own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rsegen.field.metrics.ground import field_heights, ground, lane
from rsegen.field.metrics.paths import UNREACHABLE, cheapest_paths
from rsegen.field.metrics.regions import strongly_connected
from rsegen.field.metrics.steps import steps
from rsegen.field.robot_limits import NANOMETRES, RobotLimits
from rsegen.field.stepfield import Array, Ints, Mask, StepField


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Crossing:
    """The cheapest path from the level ground on one side to that on the other, of equally cheap ones the shortest.

    Lengths are None if there is none.

    length: in the plan   cost: length + every rise and drop on it, metres   ratios: to the straight and level path
    path: (n, 2), its cells i, j; those on the ground are outside the field   costs: (n_x, n_y), inf if unreachable
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
class Traversability:
    """The traversability of a field for one robot: passable steps, coverage and crossings.

    climbable, droppable: share of the steps between blocks that it can climb, or descend; None if there are none
    cover: coverage, the share of the blocks in the largest traversable area, in which the robot can drive from every
    block to every other, measured by the blocks that carry it; region: (n_x, n_y), the mask of that area
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


def traversability(field: StepField, climber: RobotLimits) -> Traversability:
    """The traversability of a field for a robot; frames are obstacles, but are not counted as area."""
    climbable, droppable = (_share_within(field, limit / NANOMETRES) for limit in climber.limits)
    region = _largest_region(field, climber)
    return Traversability(
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
    """The mask of the blocks of the largest strongly connected component; of two equal ones, of the first.

    The largest one has the most blocks that carry the robot, as no cell below it is higher; of these, the most blocks.
    So it is the floor, and not the surroundings of a barrier, in which a wide robot would stand on it.
    """
    carrying = ground(field, climber.width)
    (low, high), (climb, drop) = carrying.moves(), climber.limits
    rise = carrying.heights.flat[high] - carrying.heights.flat[low]
    onward, back = (rise <= climb) & (-rise <= drop), (-rise <= climb) & (rise <= drop)
    group = strongly_connected(field.levels.size, low, high, onward, back).reshape(field.shape)
    blocks = ~field.frame
    carries = blocks & (field_heights(field) == carrying.heights)
    carried, size = (np.bincount(group[those], minlength=group.size) for those in (carries, blocks))
    return np.asarray(blocks & (group == (carried * (group.size + 1) + size).argmax()))


def crossing(field: StepField, climber: RobotLimits, axis: int, *, shortest: bool = True) -> Crossing:
    """The cheapest crossing of a field, along x for axis 0, along y for axis 1; the shortest of equally cheap ones."""
    carrying = lane(field, climber.width, axis)
    found = cheapest_paths(carrying, round(field.block_width * NANOMETRES), climber.limits, shortest=shortest)
    margin = (len(found.costs) - field.shape[axis]) // 2
    costs = np.where(found.costs == UNREACHABLE, np.inf, found.costs / NANOMETRES)[margin:-margin]
    costs = costs if axis == 0 else costs.T
    end = int(np.lexsort((found.moves[-1] * shortest, found.costs[-1]))[0])
    if (cost := int(found.costs[-1, end])) == UNREACHABLE:
        return _no_crossing(costs)
    path = found.path_to(found.costs.size - found.costs.shape[1] + end) - (margin, 0)
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
