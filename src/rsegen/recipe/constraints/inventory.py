"""Fits the levels of a map to the blocks that a lab has in stock."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from rsegen.field.stepfield import Ints, StepField

Blocks = NDArray[np.int64]
"""Number of blocks in stock of each level; of level 0, which needs no block, more than enough."""

_ENOUGH = 2**40


def fitted_to_inventory(field: StepField, owned: Sequence[int], rng: np.random.Generator) -> tuple[Ints, Blocks]:
    """Levels for which there are blocks, and the blocks that are left over.

    owned: number of blocks of level 1, 2, ... Where a level needs more than that, cells drawn at random get the
    nearest other level.
    """
    levels = field.levels.astype(np.int64)
    needed = np.bincount(levels[~field.frame], minlength=len(owned) + 1)
    left = blocks(owned, len(needed)) - needed
    for level in np.flatnonzero(left < 0)[::-1]:
        cells = np.flatnonzero((levels == level) & ~field.frame)
        cells = cells[np.argsort(rng.random(len(cells)), kind="stable")][: -left[level]]
        left[level] = 0
        for other in _nearest(int(level), len(left)):
            some = cells[: max(left[other], 0)]
            levels.flat[some], cells = other, cells[len(some) :]
            left[other] -= len(some)
    return levels, left


def blocks(owned: Sequence[int], levels: int) -> Blocks:
    """An inventory as an array over `levels` levels."""
    return np.array([_ENOUGH, *owned, *[0] * (levels - 1 - len(owned))], dtype=np.int64)


def lowered_to(levels: Ints, caps: Ints, left: Blocks | None) -> Ints:
    """Levels no higher than `caps`, from the blocks that are left (changed in place); None: any number of blocks."""
    found = levels.astype(np.int64)
    if left is None:
        return np.minimum(found, caps)
    for cell in np.flatnonzero(found > caps):
        level = np.flatnonzero(left[: caps.flat[cell] + 1] > 0)[-1]
        left[found.flat[cell]] += 1
        left[level] -= 1
        found.flat[cell] = level
    return found


def left_of(field: StepField, owned: Blocks) -> Blocks:
    """The blocks of each level that a field does not use."""
    return np.asarray(owned - np.bincount(field.levels[~field.frame], minlength=len(owned)))


def used(field: StepField) -> int:
    """The number of blocks of a field, those of level 0 left out."""
    return int(np.count_nonzero(field.levels))


def _nearest(level: int, levels: int) -> list[int]:
    """All other levels, nearest first; of two that are equally near, the lower first."""
    pairs = ((level - apart, level + apart) for apart in range(1, levels))
    return [other for other in chain.from_iterable(pairs) if 0 <= other < levels]
