"""Changes a map until it meets its constraints: a largest step, a robot that can cross, the blocks in stock.

    StepField --step_limited, fitted_to_inventory--> StepField --lowered_to, repeated--> StepField

The repeated part only lowers blocks, and a flat field meets every constraint, so it ends.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rsegen.field.stepfield import Ints, StepField
from rsegen.params.streams import generator
from rsegen.recipe.constraints import crossing, steps
from rsegen.recipe.constraints.inventory import Blocks, fitted_to_inventory, lowered_to
from rsegen.recipe.map_design import MapDesign


def constrained(field: StepField, design: MapDesign, index: int) -> StepField:
    """The field of map `index`, changed so that it meets the constraints of its design; unchanged if there are none."""
    if not design.is_constrained:
        return field
    if design.max_step is not None:
        field = _with(field, steps.step_limited(field, design.max_step))
    left: Blocks | None = None
    if design.inventory is not None:
        levels, left = fitted_to_inventory(field, design.inventory, generator(design.seed, index, "inventory"))
        field = _with(field, levels)
    while (caps := _caps(field, design)) is not None:
        field = _with(field, lowered_to(field.levels, caps, left))
    return field


def _caps(field: StepField, design: MapDesign) -> Ints | None:
    """The highest level that each block may have, for a constraint that is not met yet; None if all are met."""
    if design.max_step is not None:
        caps = steps.caps(field, design.max_step)
        if (field.levels > caps).any():
            return caps
    return crossing.caps(field, design.climber) if design.climber else None


def _with(field: StepField, levels: Ints) -> StepField:
    return replace(field, levels=levels.astype(np.int16))
