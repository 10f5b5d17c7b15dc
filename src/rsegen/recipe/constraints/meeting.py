"""Change a map until it meets its constraints: a largest step, a robot that can cross, the blocks in stock.

    StepField --step_limited, fitted_to_inventory--> StepField --lowered_to, repeated--> StepField

1. Largest step: the highest levels below the field that meet the limit are min over all blocks q of level(q) + limit *
   distance(p, q), the lower envelope (a distance transform with the L1 metric); the lowest levels above it are the
   same, upside down. Half-way between the two every step is within the limit too, and slopes are flattened on both
   sides.
2. Crossing, within limits of steps: along the cheapest of the paths whose highest step is least (the percolation step),
   blocks are lowered until each step of the path is within the limits.
   Crossing, for a robot: if it drives across on no straight lane (poses), the steps of a lane of its width are limited,
   from the largest one that changes anything down to none, on the lane where that lowers the fewest levels, until it
   does; the lanes a little to either side have to be driven too, as no robot keeps to a line.
3. Inventory: inventory.py.

Only lowering is repeated, and a flat field meets every constraint, so it ends; each round lowers at least one block by
a unit. If a largest step and an inventory lead to fewer blocks than that, the blocks in stock are arranged anew, around
the robot's way. Blocks that are left then go wherever all constraints are met with them. It finds a map, not the one
nearest to the design; demands that leave little room flatten the map.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import ceil
from typing import Any

import numpy as np

from rsegen.errors import ParameterError
from rsegen.field.limits import StepLimits
from rsegen.field.metrics.traversability import cells_to_each_side, crossing, lane, percolation_step
from rsegen.field.obstacles.random import Random
from rsegen.field.stepfield import Array, Ints, Mask, StepField
from rsegen.params.arrays import maps_first, maps_last, namespace
from rsegen.params.sorts import NANOMETRES
from rsegen.params.streams import generator
from rsegen.params.watch import tell
from rsegen.recipe.constraints.inventory import (
    Blocks,
    Stock,
    blocks,
    fitted_to_inventory,
    left_of,
    lowered_to,
    refilled,
    used,
)
from rsegen.recipe.difficulty import parts_of
from rsegen.recipe.map_design import MapDesign
from rsegen.standing.kinds import Standing
from rsegen.standing.lanes import across, lines_along, straight_lane

_ANYTHING = 2**30
"""A level above all levels, for cells without a limit; twice it still fits into 32 bits."""


def step_limited(field: StepField, limit: int) -> Ints:
    """Return levels whose neighbours differ by `limit` at most: steeper slopes are flattened on both sides.

    They are half-way between the highest such levels below the field and the lowest above it; all else stays.
    """
    low, high = envelope(field.levels, field, limit), -envelope(-field.levels, field, limit)
    return np.asarray(np.where(field.frame, 0, (low + high) // 2))


def is_of_steps_alone(design: MapDesign) -> bool:
    """Return whether a largest step is the only constraint, and no obstacle counts its blocks."""
    return design.crossable_by is None and design.inventory is None and not _counts_blocks(design)


def blocks_step_limited(levels: Any, design: MapDesign) -> Any:
    """Return the blocks of many maps (maps, n_x, n_y), an array or a tensor, as `step_limited` by their design.

    No other constraint would change them: half-way between two fields within the limit every step is within it.
    """
    (n_x, n_y), limit = parts_of(levels.shape[1:], design), design.max_step or 1
    parts = levels.reshape(-1, levels.shape[1] // n_x, n_x, levels.shape[2] // n_y, n_y).swapaxes(2, 3)
    fields = maps_last(parts.reshape(-1, n_x, n_y), "int32")  # what lies between frames, each a field of its own
    low, high = _lowered_to_limit(fields, limit), -_lowered_to_limit(-fields, limit)
    return maps_first((low + high) // 2).reshape(parts.shape).swapaxes(2, 3).reshape(levels.shape)


def envelope(levels: Ints, field: StepField, limit: int) -> Ints:
    """Return the highest levels (n_x, n_y) that meet the limit and are not above `levels`; _ANYTHING in frames."""
    highest = np.where(field.frame, _ANYTHING, levels.astype(np.int64))
    return _lowered_to_limit(highest, limit, field.frame)  # type: ignore[no-any-return]  # an array as the levels


def _lowered_to_limit(levels: Any, limit: int, frame: Mask | None = None) -> Any:
    """Return the highest levels within the limit and not above `levels`, (n_x, n_y, ...).

    Each pass brings the cap of a block one cell farther, so there are as many as the longest slope has cells.
    """
    minimum, highest = namespace(levels).minimum, levels
    while True:
        lower = highest + 0
        for ahead, behind in ((slice(1, None), slice(-1)), (slice(-1), slice(1, None))):
            lower[ahead] = minimum(lower[ahead], highest[behind] + limit)
            lower[:, ahead] = minimum(lower[:, ahead], highest[:, behind] + limit)
        if frame is not None:
            lower[frame] = _ANYTHING
        if (lower == highest).all():
            return highest
        highest = lower


def crossing_caps(field: StepField, crosser: Standing | StepLimits) -> Ints | None:
    """Return the highest levels along a way on which it is crossed; None if it is crossed both ways already.

    ParameterError if a robot does not get across even on a level lane, as frames are in its way.
    """
    for axis in (0, 1):
        caps = _path_caps(field, crosser, axis) if isinstance(crosser, StepLimits) else _lane_caps(field, crosser, axis)
        if caps is not None:
            return caps
    return None


def _search_for(robot: Standing) -> str:
    """Return what is told of the search for lanes."""
    return f"a way for the {robot.kind}"


def _lane_caps(field: StepField, robot: Standing, axis: int) -> Ints | None:
    """Return the highest levels along a straight lane that the robot drives; None if there is one already."""
    body, search = robot.body, _search_for(robot)
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
        tell(search, (axis + driven / len(middles) / 2) / 2)
    lines = [
        line for line in np.flatnonzero(lines_along(field, axis)).tolist() if aside <= line < turned.shape[1] - aside
    ]
    lines = lines or [turned.shape[1] // 2]
    highest = int(field.levels.max(initial=0))
    for limit in range(highest - 1, -1, -1):
        tell(search, (axis + 1 - (limit + 1) / highest / 2) / 2)
        # The lane whose levels need the least lowering, with the level ground at both ends.
        lanes = ((line, _lane_levels(turned, line, aside, limit)) for line in lines)
        line, caps = min(lanes, key=lambda lane: int((turned.levels - np.minimum(turned.levels, lane[1])).sum()))
        caps = caps if axis == 0 else caps.T
        middle = field.edges()[1 - axis][line] + field.block_width / 2
        lowered = _with(field, np.minimum(field.levels, caps))
        if straight_lane(lowered, body, axis, np.array([middle])) is not None:
            return caps
    raise ParameterError(
        "crossable_by",
        f"{robot.kind} does not get over frames of {100 * field.frame_height:g} cm; give boundary none or lower frames",
    )


def _lane_levels(field: StepField, line: int, aside: int, limit: int) -> Ints:
    """Return the highest levels along x, about a line of cells, whose steps are within a limit; _ANYTHING elsewhere."""
    caps = np.full(field.shape, _ANYTHING)
    lane = slice(max(line - aside, 0), line + aside + 1)
    levels = field.levels[:, lane].astype(np.int64)
    steps = np.minimum(np.arange(len(levels)), np.arange(len(levels))[::-1]) + 1
    levels = np.minimum(levels, limit * steps[:, None])
    part = replace(field, levels=levels.astype(np.int16), frame=field.frame[:, lane])
    caps[:, lane] = np.where(part.frame, _ANYTHING, envelope(part.levels, part, limit))
    return caps


def _path_caps(field: StepField, limits: StepLimits, axis: int) -> Ints | None:
    """Return the highest levels along the cheapest path of the least highest step; None if one leads across."""
    step, (least, most) = percolation_step(field, limits.width, axis), sorted(limits.limits)
    needed = round(step * NANOMETRES)
    # A path is searched only if the percolation step is between both limits.
    if needed <= least or (needed <= most and crossing(field, limits, axis).crosses):
        return None
    # Any of the cheapest: another would be another map.
    path = crossing(field, StepLimits.of(step, limits.width), axis, shortest=False).path
    aside = cells_to_each_side(field, limits.width)
    caps = np.full(field.shape, _ANYTHING)
    for (i, j), top in zip(path, _tops(field, limits, axis, path), strict=True):
        under = slice(max(i - aside, 0), max(i + aside + 1, 0)), slice(max(j - aside, 0), max(j + aside + 1, 0))
        caps[under] = np.minimum(caps[under], top)
    return caps


def _tops(field: StepField, limits: StepLimits, axis: int, path: Ints) -> Ints:
    """Return the highest level below the robot at each cell of its path, such that it can go on from there."""
    # Lowered forward until no rise, and then backward until no drop, exceeds the limit; backward keeps the rises.
    margin = cells_to_each_side(field, limits.width) + 1
    along = (path if axis == 0 else path[:, ::-1]) + (margin, 0)
    tops = lane(field, limits.width, axis).heights[along[:, 0], along[:, 1]]
    unit = round(field.unit * NANOMETRES)
    climb, drop = (0 if limit < unit else limit for limit in limits.limits)  # less than a block is no step at all
    for k in range(1, len(tops)):
        tops[k] = min(tops[k], tops[k - 1] + climb)
    for k in range(len(tops) - 2, -1, -1):
        tops[k] = min(tops[k], tops[k + 1] + drop)
    return np.asarray(tops // unit)


_FIRST_LANES, _LANES = 2, 8
"""Straight lanes that are driven at a time, first and then: few enough to end early and to see it move, and enough for
one call. Where one is driven to its end, it is mostly the most even one, such as one that was lowered before."""

_TRIES = 16
"""Arrangements of blocks, around another way for the robot or with more empty cells, before the best one is lowered.
Each costs a search by swaps."""

_FEWER = 0.06
"""Share of the cells that are left empty in addition, each time that no arrangement is found around a way: after 16 of
them nearly all are."""


def constrained(field: StepField, design: MapDesign, index: int) -> StepField:
    """Return the field of map `index`, changed so that it meets the constraints of its design.

    ParameterError if no block of the inventory can be used.
    """
    designed = field
    if design.max_step is not None:
        field = _with(field, step_limited(field, design.max_step))
    # The wish for blocks that are arranged anew: the limited levels, and of equal ones first those designed higher.
    like = field.levels + designed.levels / (1 + designed.levels.max(initial=0))
    if design.inventory is None:
        return _with_all_counted(_lowered(field, design, None, _caps(field, design)), designed, like, design, index)
    levels, left = fitted_to_inventory(field, design.inventory, generator(design.seed, index, "inventory"))
    fitted = _with(field, levels)
    met = _lowered(fitted, design, left.copy(), _caps(fitted, design))
    if used(met) >= used(fitted):
        return met
    if design.max_step is not None:
        met = max(met, _arranged(field, like, design, index, design.inventory), key=used)
    owned = blocks(design.inventory, len(design.inventory) + 1)
    met = refilled(met, used(fitted), like, left_of(met, owned), _is_still_met(met, design))
    if design.max_step is not None and not met.levels.any():
        raise ParameterError(
            "inventory",
            f"none of its {sum(design.inventory):,} blocks can be used on {np.count_nonzero(~field.frame):,} cells "
            f"with a max_step of {design.max_step}; give lower ones too, or one for each cell",
        )
    return met


def _is_still_met(met: StepField, design: MapDesign) -> Callable[[StepField], bool]:
    """Return what says of a field with more blocks than `met` whether it meets the constraints as that does.

    Poses of each would take too long, so the lanes that a robot drives stay as they are.
    """
    robot = design.crosser
    if robot is None or isinstance(robot, StepLimits):
        return lambda tried: _caps(tried, design) is None
    lanes, aside = np.zeros(met.shape, bool), cells_to_each_side(met, robot.width) + 1
    for axis in (0, 1):
        middle = straight_lane(met, robot.body, axis)
        line = 0 if middle is None else int(middle / met.block_width + met.shape[1 - axis] / 2)
        across = slice(max(line - aside, 0), line + aside + 1)
        lanes[(slice(None), across) if axis == 0 else (across, slice(None))] = True
    steps = replace(design, crossable_by=None)
    return lambda tried: bool((tried.levels[lanes] == met.levels[lanes]).all()) and _caps(tried, steps) is None


def _with_all_counted(met: StepField, designed: StepField, like: Array, design: MapDesign, index: int) -> StepField:
    """Return the blocks that a random obstacle counts, arranged anew if the largest step allows it; else `met`."""
    counts = designed.level_counts()
    if design.max_step is None or met.level_counts() == counts or not _counts_blocks(design):
        return met
    owned = tuple(counts.get(level, 0) for level in range(1, max(counts) + 1))
    arranged = _arranged(designed, like, design, index, owned)
    return arranged if arranged.level_counts() == counts else met


def _counts_blocks(design: MapDesign) -> bool:
    return any(isinstance(obstacle, Random) and obstacle.counts for _, obstacle in design.enabled_obstacles)


def _arranged(wished: StepField, like: Array, design: MapDesign, index: int, inventory: Sequence[int]) -> StepField:
    """Return the blocks of an inventory near `like`, with about the counts of a field; all constraints are met."""
    owned = blocks(inventory, max(len(inventory), int(wished.levels.max(initial=0))) + 1)
    stock, rng = Stock(owned=owned, limit=design.max_step or 1), generator(design.seed, index, "arrangement")
    cells, met, caps, empty = int(np.count_nonzero(~wished.frame)), [], None, 0
    # Arrange; if the robot cannot cross, keep its way low and arrange around it. The fullest of all tries counts.
    for _ in range(_TRIES):
        levels = stock.arranged(wished, like, rng, caps, empty)
        if levels is None:
            caps, empty = None, empty + ceil(_FEWER * cells)
            continue
        field = _with(wished, levels)
        on_its_way = _caps(field, design)
        met.append(_lowered(field, design, left_of(field, owned), on_its_way))
        if on_its_way is None:
            break
        caps = envelope(on_its_way if caps is None else np.minimum(on_its_way, caps), field, stock.limit)
    return max(met, key=used)


def _lowered(field: StepField, design: MapDesign, left: Blocks | None, caps: Ints | None) -> StepField:
    """Return a field, of which `_caps` are known, with blocks lowered until it meets the constraints, from the blocks
    that are left.
    """
    while caps is not None:
        field = _with(field, lowered_to(field.levels, caps, left))
        caps = _caps(field, design)
    if isinstance(design.crosser, Standing):
        tell(_search_for(design.crosser), 1)
    return field


def _caps(field: StepField, design: MapDesign) -> Ints | None:
    """Return the highest level that each block may have, for a constraint that is not met yet; None if all are met."""
    if design.max_step is not None:
        caps = envelope(field.levels, field, design.max_step)
        if (field.levels > caps).any():
            return caps
    return crossing_caps(field, design.crosser) if design.crosser else None


def _with(field: StepField, levels: Ints) -> StepField:
    return replace(field, levels=levels.astype(np.int16))
