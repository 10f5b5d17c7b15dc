"""Lower blocks until a robot drives across: the constraint `crossable_by` of a kind of robot.

A lane is straight, and as wide as the robot. Where it drives none, the steps of one are limited, from the largest limit
that changes anything down to none, on the lane where that lowers the fewest levels, until it is driven.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from rsegen.errors import ParameterError
from rsegen.field.crossing import NO_CAP
from rsegen.field.stepfield import Ints, Mask, StepField
from rsegen.field.traversability import cells_to_each_side
from rsegen.params.watch import report_share
from rsegen.recipe.constraints.meeting import envelope
from rsegen.standing.body import Body
from rsegen.standing.lanes import across, lines_along, straight_lane

if TYPE_CHECKING:
    from rsegen.standing.kinds import RobotOnField

_FIRST_LANES, _LANES = 2, 8
"""Straight lanes that are driven at a time, first and then: few, as one of the first, most even ones is mostly
driven to its end, but enough for one call."""


def lane_caps(field: StepField, robot: RobotOnField, axis: int) -> Ints | None:
    """Return the highest levels along a straight lane that the robot drives; None if there is one already."""
    body, search = robot.body, robot.search
    turned = field if axis == 0 else replace(field, levels=field.levels.T, frame=field.frame.T)
    aside = cells_to_each_side(field, body.width)
    # Lanes are driven some at a time, the most even ones first, until one is driven to its end. Each axis is half of
    # the search: up to a half of that for the lanes as they are, the rest for lower and lower ones.
    steps = np.pad(np.abs(np.diff(turned.levels.astype(np.int64), axis=0)).sum(axis=0), aside)
    unevenness = np.lib.stride_tricks.sliding_window_view(steps, 2 * aside + 1).sum(axis=1)[lines_along(field, axis)]
    middles = across(field, axis)[np.argsort(unevenness, kind="stable")]
    driven, count = 0, _FIRST_LANES
    while driven < len(middles):
        if straight_lane(field, body, axis, middles[driven : driven + count]) is not None:
            return None
        driven, count = min(driven + count, len(middles)), _LANES
        report_share(search, (axis + driven / len(middles) / 2) / 2)
    lines = [
        line for line in np.flatnonzero(lines_along(field, axis)).tolist() if aside <= line < turned.shape[1] - aside
    ]
    lines = lines or [turned.shape[1] // 2]
    highest = int(field.levels.max(initial=0))
    for limit in range(highest - 1, -1, -1):
        report_share(search, (axis + 1 - (limit + 1) / highest / 2) / 2)
        # The lane whose levels need the least lowering, with the level ground at both ends.
        lanes = ((line, _lane_levels(turned, line, aside, limit)) for line in lines)
        line, caps = min(lanes, key=lambda lane: int((turned.levels - np.minimum(turned.levels, lane[1])).sum()))
        caps = caps if axis == 0 else caps.T
        middle = field.edges()[1 - axis][line] + field.block_width / 2
        lowered = replace(field, levels=np.minimum(field.levels, caps).astype(np.int16))
        if straight_lane(lowered, body, axis, np.array([middle])) is not None:
            return caps
    raise ParameterError(
        "crossable_by",
        f"{robot.kind} does not get over frames of {100 * field.frame_height:g} cm; give boundary none or lower frames",
    )


def _lane_levels(field: StepField, line: int, aside: int, limit: int) -> Ints:
    """Return the highest levels along x, about a line of cells, whose steps are within a limit; NO_CAP elsewhere."""
    caps = np.full(field.shape, NO_CAP)
    lane = slice(max(line - aside, 0), line + aside + 1)
    levels = field.levels[:, lane].astype(np.int64)
    steps = np.minimum(np.arange(len(levels)), np.arange(len(levels))[::-1]) + 1
    levels = np.minimum(levels, limit * steps[:, None])
    part = replace(field, levels=levels.astype(np.int16), frame=field.frame[:, lane])
    caps[:, lane] = np.where(part.frame, NO_CAP, envelope(part.levels, part, limit))
    return caps


def lane_cells(field: StepField, body: Body) -> Mask:
    """Return the cells of the straight lanes along x and y that a body drives, one more to each side, (n_x, n_y)."""
    lanes, aside = np.zeros(field.shape, bool), cells_to_each_side(field, body.width) + 1
    for axis in (0, 1):
        middle = straight_lane(field, body, axis)
        line = 0 if middle is None else int(middle / field.block_width + field.shape[1 - axis] / 2)
        beside = slice(max(line - aside, 0), line + aside + 1)
        lanes[(slice(None), beside) if axis == 0 else (beside, slice(None))] = True
    return lanes
