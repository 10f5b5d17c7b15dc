"""Changes a map until it meets its constraints: a largest step, a robot that can cross, the blocks in stock.

    StepField --step_limited, fitted_to_inventory--> StepField --lowered_to, repeated--> StepField

The repeated part only lowers blocks, and a flat field meets every constraint, so it ends. If a largest step and an
inventory lead to fewer blocks than that, the blocks in stock are arranged anew. Blocks that are left then go wherever
all constraints are met with them.

Limits the height difference between neighbouring blocks; blocks on two sides of a frame are not neighbours.

Lowers blocks so that a robot can cross a map from west to east and from south to north.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import ceil

import numpy as np

from rsegen.errors import ParameterError
from rsegen.field.metrics.traversability import crossing, lane, percolation_step
from rsegen.field.obstacles.random import Random
from rsegen.field.robot_limits import NANOMETRES, RobotLimits, cells_to_each_side
from rsegen.field.stepfield import Array, Ints, StepField
from rsegen.params.streams import generator
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
from rsegen.recipe.map_design import MapDesign

_ANYTHING = 2**30


def step_limited(field: StepField, limit: int) -> Ints:
    """Levels whose neighbours differ by `limit` at most: steeper slopes are flattened on both sides, the rest stays.

    Half-way between the highest such levels below the field and the lowest above it.
    """
    low, high = envelope(field.levels, field, limit), -envelope(-field.levels, field, limit)
    return np.asarray(np.where(field.frame, 0, (low + high) // 2))


def envelope(levels: Ints, field: StepField, limit: int) -> Ints:
    """The highest levels that meet the limit and are not above `levels`, (n_x, n_y): the least over all blocks of
    level + limit * distance from block to block; above all levels in frame cells.
    """
    found = np.where(field.frame, _ANYTHING, levels.astype(np.int64))
    while True:
        p = np.pad(found, 1, constant_values=_ANYTHING)
        lowest = np.minimum(np.minimum(p[2:, 1:-1], p[:-2, 1:-1]), np.minimum(p[1:-1, 2:], p[1:-1, :-2]))
        lower = np.where(field.frame, _ANYTHING, np.minimum(found, lowest + limit))
        if (lower == found).all():
            return found
        found = lower


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


_TRIES = 16
"""How often blocks are arranged, around another way for the robot or fewer of them, before they are lowered."""

_FEWER = 0.06
"""The share of cells that are left empty in addition, if no arrangement is found around a way."""


def constrained(field: StepField, design: MapDesign, index: int) -> StepField:
    """The field of map `index`, changed so that it meets the constraints of its design.

    ParameterError if no block of the inventory can be used.
    """
    designed = field
    if design.max_step is not None:
        field = _with(field, step_limited(field, design.max_step))
    like = field.levels + designed.levels / (1 + designed.levels.max(initial=0))
    if design.inventory is None:
        found = _lowered(field, design, None)
        return _with_all_counted(found, designed, like, design, index)
    levels, left = fitted_to_inventory(field, design.inventory, generator(design.seed, index, "inventory"))
    fitted = _with(field, levels)
    found = _lowered(fitted, design, left.copy())
    if used(found) >= used(fitted):
        return found
    if design.max_step is not None:
        found = max(found, _arranged(fitted, like, design, index, design.inventory), key=used)
    owned = blocks(design.inventory, len(design.inventory) + 1)
    found = refilled(found, used(fitted), like, left_of(found, owned), lambda tried: _caps(tried, design) is None)
    if design.max_step is not None and not found.levels.any():
        raise ParameterError(
            "inventory",
            f"none of its {sum(design.inventory):,} blocks can be used on {np.count_nonzero(~field.frame):,} cells "
            f"with a max_step of {design.max_step}; give lower ones too, or one for each cell",
        )
    return found


def _with_all_counted(found: StepField, designed: StepField, like: Array, design: MapDesign, index: int) -> StepField:
    """The blocks that a random obstacle counts, arranged anew if the largest step allows it; else the field found."""
    counts = designed.level_counts()
    if design.max_step is None or found.level_counts() == counts or not _counts_blocks(design):
        return found
    owned = tuple(counts.get(level, 0) for level in range(1, max(counts) + 1))
    arranged = _arranged(designed, like, design, index, owned)
    return arranged if arranged.level_counts() == counts else found


def _counts_blocks(design: MapDesign) -> bool:
    return any(isinstance(obstacle, Random) and obstacle.counts for obstacle in design.obstacles)


def _arranged(fitted: StepField, like: Array, design: MapDesign, index: int, inventory: Sequence[int]) -> StepField:
    """The blocks of an inventory arranged near `like`, with about the counts of a field; all constraints are met."""
    owned = blocks(inventory, len(inventory) + 1)
    stock, rng = Stock(owned=owned, limit=design.max_step or 1), generator(design.seed, index, "arrangement")
    cells, found, caps, empty = int(np.count_nonzero(~fitted.frame)), [], None, 0
    for _ in range(_TRIES):
        levels = stock.arranged(fitted, like, rng, caps, empty)
        if levels is None:
            caps, empty = None, empty + ceil(_FEWER * cells)
            continue
        field = _with(fitted, levels)
        found.append(_lowered(field, design, left_of(field, owned)))
        on_its_way = crossing_caps(field, design.climber) if design.climber else None
        if on_its_way is None:
            break
        caps = envelope(on_its_way if caps is None else np.minimum(on_its_way, caps), field, stock.limit)
    return max(found, key=used)


def _lowered(field: StepField, design: MapDesign, left: Blocks | None) -> StepField:
    """A field whose blocks are lowered until it meets the constraints, from the blocks that are left."""
    while (caps := _caps(field, design)) is not None:
        field = _with(field, lowered_to(field.levels, caps, left))
    return field


def _caps(field: StepField, design: MapDesign) -> Ints | None:
    """The highest level that each block may have, for a constraint that is not met yet; None if all are met."""
    if design.max_step is not None:
        caps = envelope(field.levels, field, design.max_step)
        if (field.levels > caps).any():
            return caps
    return crossing_caps(field, design.climber) if design.climber else None


def _with(field: StepField, levels: Ints) -> StepField:
    return replace(field, levels=levels.astype(np.int16))
