"""Changes a map until it meets its constraints: a largest step, a robot that can cross, the blocks in stock.

    StepField --step_limited, fitted_to_inventory--> StepField --lowered_to, repeated--> StepField

The repeated part only lowers blocks, and a flat field meets every constraint, so it ends. If a largest step and an
inventory lead to fewer blocks than that, the blocks in stock are arranged anew. Blocks that are left then go wherever
all constraints are met with them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import ceil

import numpy as np

from rsegen.errors import ParameterError
from rsegen.field.obstacles.random import Random
from rsegen.field.stepfield import Array, Ints, StepField
from rsegen.params.streams import generator
from rsegen.recipe.constraints.arrangement import Stock
from rsegen.recipe.constraints.crossing import crossing_caps
from rsegen.recipe.constraints.inventory import Blocks, blocks, fitted_to_inventory, left_of, lowered_to, used
from rsegen.recipe.constraints.refilling import refilled
from rsegen.recipe.constraints.steps import envelope, step_limited
from rsegen.recipe.map_design import MapDesign

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
    return any(isinstance(each.obstacle, Random) and each.obstacle.counts for each in design.obstacles)


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
