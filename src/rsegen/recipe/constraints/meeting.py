"""Change a map until it meets its constraints: a largest step, a robot that can cross, the blocks in stock.

    StepField --step_limited, fitted_to_inventory--> StepField --lowered_to, repeated--> StepField

1. Largest step: the highest levels below the field that meet the limit are min over all blocks q of level(q) + limit *
   distance(p, q), the lower envelope (a distance transform with the L1 metric); the lowest levels above it are the
   same, upside down. Half-way between the two every step is within the limit too, and slopes are flattened on both
   sides.
2. Crossing, within limits of steps: along the cheapest of the paths whose highest step is least (the percolation step),
   blocks are lowered until each step of the path is within the limits.
   Crossing, for a robot: if it drives across on no straight lane with room to spare (poses), blocks of a lane of its
   width are lowered where its drive ends, until it does (standing/lowering.py).
3. Inventory: inventory.py.

Only lowering is repeated, and a flat field meets every constraint, so it ends; each round lowers at least one block by
a unit. If a largest step and an inventory lead to fewer blocks than that, the blocks in stock are arranged anew, around
the robot's way. Blocks that are left then go wherever all constraints are met with them. It finds a map, not the one
nearest to the design; demands that leave little room flatten the map.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import ceil, prod
from typing import Any

import numpy as np

from rsegen.errors import ParameterError
from rsegen.field.crossing import CrossingModel, StepLimits
from rsegen.field.stepfield import NO_CAP, Array, Ints, Levels, Mask, StepField
from rsegen.field.sweeps import LARGE, lowered_to_cross
from rsegen.obstacles.random import Random
from rsegen.params.arrays import as_numpy, asarray, maps_first, maps_last, namespace
from rsegen.params.streams import Streams, generator
from rsegen.params.watch import report_share
from rsegen.recipe.constraints.inventory import (
    Blocks,
    Stock,
    block_counts,
    fitted_to_inventory,
    left_of,
    lowered_to,
    refilled,
    used,
)
from rsegen.recipe.difficulty import parts_of
from rsegen.recipe.map_design import MapDesign


def step_limited(field: StepField, limit: int) -> Ints:
    """Return levels whose neighbours differ by `limit` at most: steeper slopes are flattened on both sides.

    They are half-way between the highest such levels below the field and the lowest above it; all else stays.
    """
    low, high = envelope(field.levels, field, limit), -envelope(-field.levels, field, limit)
    return np.asarray(np.where(field.frame, 0, (low + high) // 2))


def are_met_together(design: MapDesign) -> bool:
    """Return whether the constraints of many maps are met by the same calls: of steps and paths, on maps not large."""
    if design.inventory is not None or (design.max_step is not None and counts_blocks(design)):
        return False
    is_small = prod(design.cells) <= LARGE
    return design.crossable_by is None or (isinstance(design.crosser, StepLimits) and is_small)


def blocks_constrained(levels: Levels, design: MapDesign, like: StepField) -> Levels:
    """Return the blocks of many maps (maps, n_x, n_y), an array or a tensor, as `constrained` by their design.

    like: any field of the design.
    """
    if design.max_step is not None:
        levels = _blocks_step_limited(levels, design)
    if not isinstance(design.crosser, StepLimits):
        return levels
    inside, blocks = np.ix_(like.inside(0), like.inside(1)), maps_last(as_numpy(levels), "int16")
    fields = np.zeros((*like.shape, len(levels)), dtype=np.int16)
    fields[inside] = blocks
    left = np.arange(len(levels))  # maps of which it is not known whether they are crossed along both axes
    while len(left):
        own, again = fields[:, :, left], np.zeros(len(left), dtype=bool)
        for axis in (0, 1):
            part = np.flatnonzero(~again)
            lowered, again[part] = lowered_to_cross(own[:, :, part], like, design.crosser, axis)
            if design.max_step is not None:
                lowered = np.where(like.frame[:, :, None], 0, envelope(lowered, like, design.max_step))
            own[:, :, part] = lowered
        fields[:, :, left] = own
        left = left[again]
    return asarray(maps_first(fields[inside]), levels)  # type: ignore[no-any-return]  # as the levels


def _blocks_step_limited(levels: Any, design: MapDesign) -> Any:
    """Return the blocks of many maps (maps, n_x, n_y), an array or a tensor, as `step_limited` by their design."""
    (n_x, n_y), limit = parts_of(levels.shape[1:], design), design.max_step or 1
    parts = levels.reshape(-1, levels.shape[1] // n_x, n_x, levels.shape[2] // n_y, n_y).swapaxes(2, 3)
    fields = maps_last(parts.reshape(-1, n_x, n_y), "int32")  # what lies between frames, each its own field
    low, high = _lowered_to_limit(fields, limit), -_lowered_to_limit(-fields, limit)
    return maps_first((low + high) // 2).reshape(parts.shape).swapaxes(2, 3).reshape(levels.shape)


def envelope(levels: Ints, field: StepField, limit: int) -> Ints:
    """Return the highest levels (n_x, n_y, ...) that meet the limit and are not above `levels`; NO_CAP in frames."""
    frame = field.frame.reshape(*field.shape, *[1] * (levels.ndim - 2))
    highest = np.where(frame, NO_CAP, levels.astype(np.int64))
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
            lower[frame] = NO_CAP
        if (lower == highest).all():
            return highest
        highest = lower


def crossing_caps(field: StepField, crosser: CrossingModel) -> Ints | None:
    """Return the highest levels along a way on which it is crossed; None if it is crossed both ways already.

    ParameterError if a robot does not get across even on a level lane, as frames are in its way.
    """
    return next((caps for axis in (0, 1) if (caps := crosser.caps(field, axis)) is not None), None)


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
    owned = block_counts(design.inventory, len(design.inventory) + 1)
    met = refilled(met, used(fitted), like, left_of(met, owned), _is_still_met(met, design))
    if design.max_step is not None and not met.levels.any():
        raise ParameterError(
            "inventory",
            f"none of its {sum(design.inventory):,} blocks can be used on {np.count_nonzero(~field.frame):,} cells "
            f"with a max_step of {design.max_step}; add lower ones, or one for each cell",
        )
    return met


def _is_still_met(met: StepField, design: MapDesign) -> Callable[[StepField], bool]:
    """Return what says of a field with more blocks than `met` whether it meets the constraints as that does.

    Poses of each would take too long, so the lanes that a robot drives stay as they are.
    """
    lanes = design.crosser.lanes(met) if design.crosser else None
    if lanes is None:
        return lambda tried: _caps(tried, design) is None
    steps = replace(design, crossable_by=None)
    return lambda tried: bool((tried.levels[lanes] == met.levels[lanes]).all()) and _caps(tried, steps) is None


def _with_all_counted(met: StepField, designed: StepField, like: Array, design: MapDesign, index: int) -> StepField:
    """Return the blocks that a random obstacle counts, arranged anew if the largest step allows it; else `met`."""
    counts = designed.level_counts()
    if design.max_step is None or met.level_counts() == counts or not counts_blocks(design):
        return met
    owned = tuple(counts.get(level, 0) for level in range(1, max(counts) + 1))
    arranged = _arranged(designed, like, design, index, owned)
    return arranged if arranged.level_counts() == counts else met


def counts_blocks(design: MapDesign) -> bool:
    """Return whether a random obstacle of a design says how many blocks of each level it has."""
    return any(isinstance(obstacle, Random) and obstacle.counts for _, obstacle in design.enabled_obstacles)


def _arranged(wished: StepField, like: Array, design: MapDesign, index: int, inventory: Sequence[int]) -> StepField:
    """Return the blocks of an inventory near `like`, with about the counts of a field; all constraints are met."""
    owned = block_counts(inventory, max(len(inventory), int(wished.levels.max(initial=0))) + 1)
    stock, stream = Stock(owned=owned, limit=design.max_step or 1), Streams.of(design.seed, [index], "arrangement")
    cells, met, caps, empty = int(np.count_nonzero(~wished.frame)), [], None, 0
    # Arrange; if the robot cannot cross, keep its way low and arrange around it. The fullest of all tries counts.
    for _ in range(_TRIES):
        levels = stock.arranged(wished, like, stream, caps, empty)
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
    if design.crosser and design.crosser.search:
        report_share(design.crosser.search, 1)
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
