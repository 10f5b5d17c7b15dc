"""The blocks that a lab has in stock, on the cells of a map.

Without a largest step (`fitted_to_inventory`): if a level needs more blocks than there are, random cells of it get the
nearest level that is left. The highest levels choose first, as they have the fewest alternatives.

With a largest step (`Stock.arranged`): first the counts, then their places. With a_t the number of cells up to level t,
c_t the blocks in stock of level t, and n(a) the cells that the first a cells of a fill order and their neighbours take
up (field/obstacles/rearranged.py), counts are possible if and only if

    a_t <= a_(t+1) <= a_t + c_(t+1),    n(a_t) <= a_(t+limit),    a of the highest level = all cells.

All of it has the form "one is at least a rising function of another", so there is a least solution above given values,
and a greatest one below (a lattice, Tarski 1955): both are found by raising, or lowering, what is not right yet. The
levels are then filled in along the fill order, and swapped towards the design.

`refilled` puts blocks that other constraints left unused back, wherever these are met with them too.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from rsegen.field.obstacles.rearranged import cells_with_neighbours, fill_order, rearranged_like
from rsegen.field.stepfield import Array, Ints, StepField

Blocks = NDArray[np.int64]
"""Number of blocks in stock of each level; of level 0, which needs no block, more than enough."""

_ENOUGH = 2**40
"""Blocks of level 0, which is no block: more than cells of any map."""


def fitted_to_inventory(field: StepField, owned: Sequence[int], rng: np.random.Generator) -> tuple[Ints, Blocks]:
    """Return levels for which there are blocks, and the blocks that are left over.

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
    """Return an inventory as an array over `levels` levels."""
    return np.array([_ENOUGH, *owned, *[0] * (levels - 1 - len(owned))], dtype=np.int64)


def lowered_to(levels: Ints, caps: Ints, left: Blocks | None) -> Ints:
    """Return levels no higher than `caps`, from the blocks that are left (changed in place); None: any number of
    blocks.
    """
    lowered = levels.astype(np.int64)
    if left is None:
        return np.minimum(lowered, caps)
    for cell in np.flatnonzero(lowered > caps):
        level = np.flatnonzero(left[: caps.flat[cell] + 1] > 0)[-1]
        left[lowered.flat[cell]] += 1
        left[level] -= 1
        lowered.flat[cell] = level
    return lowered


def left_of(field: StepField, owned: Blocks) -> Blocks:
    """Return the blocks of each level that a field does not use."""
    return np.asarray(owned - np.bincount(field.levels[~field.frame], minlength=len(owned)))


def used(field: StepField) -> int:
    """Return the number of blocks of a field, without cells of level 0."""
    return int(np.count_nonzero(field.levels))


def _nearest(level: int, levels: int) -> list[int]:
    """Return all other levels, nearest first; of two equally near ones, the lower first."""
    pairs = ((level - apart, level + apart) for apart in range(1, levels))
    return [other for other in chain.from_iterable(pairs) if 0 <= other < levels]


_Cumulative = NDArray[np.int64]


class BlockCounts:
    """Possible counts of blocks, from `owned` blocks of level 0, 1, ...; with_neighbours: n(m) for m = 0 .. all
    cells.
    """

    def __init__(self, owned: Ints, limit: int, with_neighbours: Ints) -> None:
        self._cells = len(with_neighbours) - 1
        self._stock = np.minimum(np.concatenate([[0], owned[1:]]), self._cells).cumsum()
        self._limit = limit
        self._n = with_neighbours

    def nearest(self, wished: Ints, blocks: int, lowest: Ints) -> Ints:
        """Return possible counts of level 0, 1, ... near `wished`, with at least `blocks` blocks, or as many as
        possible.

        lowest: for each level, the least number of cells that are no higher.
        """
        most = np.full(len(wished), self._cells)
        most[0] = max(self._cells - blocks, self._least(lowest)[0])
        wish = np.minimum(np.cumsum(wished), self._greatest(most))
        return np.diff(self._least(np.maximum(wish, lowest)), prepend=0)

    def _least(self, values: Ints) -> _Cumulative:
        """Return the least solution above some values: with the fewest low blocks, so with the most blocks."""
        least = np.asarray(values, dtype=np.int64).copy()
        least[-1] = self._cells
        while True:
            before = least.copy()
            least = np.maximum.accumulate(least)
            least[self._limit :] = np.maximum(least[self._limit :], self._n[least[: -self._limit]])
            least = self._stock + np.maximum.accumulate((least - self._stock)[::-1])[::-1]
            if (least == before).all():
                return np.asarray(least)

    def _greatest(self, values: Ints) -> _Cumulative:
        """Return the greatest solution below some values, if there is one below them."""
        greatest = values
        while True:
            before = greatest
            greatest = np.minimum.accumulate(greatest[::-1])[::-1]
            within = np.searchsorted(self._n, greatest[self._limit :], side="right") - 1
            greatest[: -self._limit] = np.minimum(greatest[: -self._limit], within)
            greatest = self._stock + np.minimum.accumulate(greatest - self._stock)
            if (greatest == before).all():
                return np.asarray(greatest)


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Stock:
    """Blocks of level 0, 1, ... in stock, and the largest step between neighbours that they are arranged under."""

    owned: Blocks
    limit: int

    def arranged(
        self, field: StepField, like: Array, rng: np.random.Generator, caps: Ints | None = None, empty: int = 0
    ) -> Ints | None:
        """Return levels with about the counts of a field, as near to `like` as swaps bring them, and not above `caps`.

        They use as many blocks as `like` has above 0, or as the stock and the limit allow. None if no such order is
        found, which happens with caps alone. empty: least number of cells of level 0.
        """
        there = ~field.frame
        wished = np.bincount(field.levels[there], minlength=len(self.owned))
        low = np.full(len(wished), min(empty, int(there.sum())))
        if caps is not None:
            low = np.maximum(low, np.bincount(caps[there].clip(0, len(low) - 1), minlength=len(low)).cumsum())
        n = cells_with_neighbours(fill_order(there, like), there)
        counts = BlockCounts(self.owned, self.limit, n).nearest(wished, int((like[there] > 0).sum()), low)
        levels = np.full(field.shape, -1)
        levels[there] = np.repeat(np.arange(len(counts)), counts)
        arranged = rearranged_like(levels, self.limit, rng, like, caps)
        return None if arranged is None else np.maximum(arranged, 0)


_CHECKED_CELLS = 1_000_000
"""Cells of all the fields that are tried together: half a second of work at most."""


def refilled(
    field: StepField, blocks: int, like: Array, left: Blocks, is_met: Callable[[StepField], bool]
) -> StepField:
    """Return a field with left blocks on empty cells, up to `blocks` blocks in all.

    like: (n_x, n_y), the wished levels: cells of the highest are tried first, each with the nearest level that is left,
    then with lower ones. is_met: whether a field meets all constraints; each field is tried alone.
    """
    # Every try checks the whole field, so the number of tries is limited by its size.
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
