"""The blocks that a lab owns, and a map that is built of them alone."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from rsegen.field.stepfield import Ints, StepField

Blocks = NDArray[np.int64]
"""How many blocks there are of each level; of level 0, which is none, always more than enough."""

_ENOUGH = 2**40


def fitted(field: StepField, owned: Sequence[int], rng: np.random.Generator) -> tuple[Ints, Blocks]:
    """Levels for which there are blocks, and those that are left: too many of one length are replaced by the nearest.

    owned: how many blocks of level 1, 2, ...; which of too many keep theirs is drawn.
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
    """An inventory as a row of so many levels."""
    return np.array([_ENOUGH, *owned, *[0] * (levels - 1 - len(owned))], dtype=np.int64)


def lowered(levels: Ints, caps: Ints, left: Blocks | None) -> Ints:
    """Levels no higher than `caps`, made of the blocks that are left, which change; None: there are always more."""
    found = levels.astype(np.int64)
    if left is None:
        return np.minimum(found, caps)
    for cell in np.flatnonzero(found > caps):
        level = np.flatnonzero(left[: caps.flat[cell] + 1] > 0)[-1]
        left[found.flat[cell]] += 1
        left[level] -= 1
        found.flat[cell] = level
    return found


def _nearest(level: int, levels: int) -> list[int]:
    """The other levels, the nearest first, of two as near the lower."""
    pairs = ((level - apart, level + apart) for apart in range(1, levels))
    return [other for other in chain.from_iterable(pairs) if 0 <= other < levels]
