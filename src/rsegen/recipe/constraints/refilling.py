"""Puts back blocks that other constraints left unused, wherever these are met with them too."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from rsegen.field.stepfield import Array, StepField
from rsegen.recipe.constraints.inventory import Blocks, used

_CHECKED_CELLS = 1_000_000
"""Cells of all the fields that are tried: half a second of work at most."""


def refilled(
    field: StepField, blocks: int, like: Array, left: Blocks, is_met: Callable[[StepField], bool]
) -> StepField:
    """A field with blocks that are left on cells that are empty, up to so many blocks in all.

    like: (n_x, n_y), the levels that are wished for: the highest of them are tried first, each with the nearest level
    that is left, then with lower ones. is_met: whether a field meets all constraints; each field is tried alone.
    """
    left, tries = left.copy(), _CHECKED_CELLS // field.levels.size
    empty = np.flatnonzero((field.levels == 0) & ~field.frame)
    for cell in empty[np.argsort(-like.flat[empty], kind="stable")]:
        if used(field) >= blocks:
            break
        owned = np.flatnonzero(left[1:] > 0) + 1
        wished = [level for level in owned[::-1] if level <= max(like.flat[cell], owned.min(initial=1))]
        for level in wished[:tries]:
            tries -= 1
            levels = field.levels.copy()
            levels.flat[cell] = level
            if is_met(tried := replace(field, levels=levels)):
                field = tried
                left[level] -= 1
                break
    return field
