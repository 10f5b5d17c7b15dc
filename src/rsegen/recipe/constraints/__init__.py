r"""What a map keeps to, whatever its obstacles: a largest step, a robot that gets across, the blocks that there are.

    StepField --evened, fitted--> StepField --lowered, again and again--> StepField that keeps to all of it

Blocks are only lowered in the end, and a field of nothing keeps to everything, so it ends.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rsegen.field.stepfield import Ints, StepField
from rsegen.params.streams import generator
from rsegen.recipe.constraints import crossing, steps
from rsegen.recipe.constraints.inventory import Blocks, fitted, lowered
from rsegen.recipe.recipe import Recipe


def constrained(field: StepField, recipe: Recipe, index: int) -> StepField:
    """Map `index` of a recipe as its constraints have it; the same field where there are none."""
    if not recipe.is_constrained:
        return field
    if recipe.max_step is not None:
        field = _with(field, steps.evened(field, recipe.max_step))
    left: Blocks | None = None
    if recipe.inventory is not None:
        levels, left = fitted(field, recipe.inventory, generator(recipe.seed, index, "inventory"))
        field = _with(field, levels)
    while (caps := _caps(field, recipe)) is not None:
        field = _with(field, lowered(field.levels, caps, left))
    return field


def _caps(field: StepField, recipe: Recipe) -> Ints | None:
    """The highest levels that its blocks may have; None where they are no higher."""
    if recipe.max_step is not None:
        caps = steps.caps(field, recipe.max_step)
        if (field.levels > caps).any():
            return caps
    return crossing.caps(field, recipe.climber) if recipe.climber else None


def _with(field: StepField, levels: Ints) -> StepField:
    return replace(field, levels=levels.astype(np.int16))
