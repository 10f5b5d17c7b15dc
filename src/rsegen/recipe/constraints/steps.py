"""Limits the height difference between neighbouring blocks; blocks on two sides of a frame are not neighbours."""

from __future__ import annotations

import numpy as np

from rsegen.field.stepfield import Ints, StepField

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
