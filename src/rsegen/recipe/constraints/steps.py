"""No two neighbouring blocks differ by more than so many levels; where a frame is between, they are no neighbours."""

from __future__ import annotations

import numpy as np

from rsegen.field.stepfield import Ints, StepField

_ANYTHING = 2**30


def evened(field: StepField, limit: int) -> Ints:
    """Levels half-way between the highest below the field and the lowest above it that keep to the limit.

    So flanks that are too steep give way on both sides, and all that is not stays.
    """
    low, high = _envelope(field.levels, field, limit), -_envelope(-field.levels, field, limit)
    return np.asarray(np.where(field.frame, 0, (low + high) // 2))


def caps(field: StepField, limit: int) -> Ints:
    """The highest level that each block may have where none is raised."""
    return _envelope(field.levels, field, limit)


def _envelope(levels: Ints, field: StepField, limit: int) -> Ints:
    """min over all blocks of level + limit * way to them, from block to block; beyond all levels in frame cells."""
    found = np.where(field.frame, _ANYTHING, levels.astype(np.int64))
    while True:
        p = np.pad(found, 1, constant_values=_ANYTHING)
        lowest = np.minimum(np.minimum(p[2:, 1:-1], p[:-2, 1:-1]), np.minimum(p[1:-1, 2:], p[1:-1, :-2]))
        lower = np.where(field.frame, _ANYTHING, np.minimum(found, lowest + limit))
        if (lower == found).all():
            return found
        found = lower
