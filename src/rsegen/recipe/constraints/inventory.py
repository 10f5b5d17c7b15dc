"""The blocks that a lab has in stock, on the cells of a map.

The objective, in this order: the fewest cells without the block that they were designed with, the least sum of
differences from the designed levels, the least of the largest difference. So no hole is made while a block is left.

Without a largest step (`fitted_to_inventory`) it is met exactly. Levels are points on a line, and the cost of carrying
blocks along it is a convex function of how many are carried past each point (`Carried`), so its least is found from one
end to the other by a list of slopes ("slope trick"; as for a transport problem on a path). Which of the cells of one
level get which block is drawn at random.

With a largest step (`Stock.arranged`): first the counts, then their places. With a_t the number of cells up to level t,
c_t the blocks in stock of level t, and n(a) the cells that the first a cells of a fill order and their neighbours take
up (obstacles/rearranged.py), counts are possible if and only if

    a_t <= a_(t+1) <= a_t + c_(t+1),    n(a_t) <= a_(t+limit),    a of the highest level = all cells.

All of it has the form "one is at least a rising function of another", so there is a least solution above given values,
and a greatest one below (a lattice, Tarski 1955): both are found by raising, or lowering, what is not right yet. The
levels are then filled in along the fill order, and swapped towards the design.

`refilled` puts blocks that other constraints left unused back, wherever these are met with them too.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from heapq import heappop, heappush

import numpy as np
from numpy.typing import NDArray

from rsegen.field.stepfield import Array, Ints, StepField
from rsegen.obstacles.rearranged import cells_with_neighbours, fill_order, rearranged_like
from rsegen.params.streams import Streams

Blocks = NDArray[np.int64]
"""Number of blocks in stock of each level; of level 0, which needs no block, more than enough."""

_ENOUGH = 2**40
"""Blocks of level 0, which is no block: more than cells of any map."""


def fitted_to_inventory(field: StepField, owned: Sequence[int], rng: np.random.Generator) -> tuple[Ints, Blocks]:
    """Return levels for which there are blocks, and the blocks that are left over.

    owned: number of blocks of level 1, 2, ... As many cells as possible of those that are designed with a block have
    one; their levels are as near as possible to the design.
    """
    # Counts by level are exact; then the cells of one level, in a random order, get the blocks that are used for it.
    levels = field.levels.astype(np.int64)
    wished, taken = nearest_counts(field, owned)
    stock, ends = block_counts(owned, len(wished)), np.cumsum(wished)
    blocks_in_order = np.repeat(np.arange(len(taken)), taken)  # the lowest cells get the lowest of the blocks
    for level in np.flatnonzero(wished):
        cells = np.flatnonzero((field.levels == level) & ~field.frame)
        cells = cells[np.argsort(rng.random(len(cells)), kind="stable")]
        levels.flat[cells] = blocks_in_order[ends[level] - wished[level] : ends[level]]
    taken[0] = 0
    return levels, stock - taken


def nearest_counts(design: StepField, owned: Sequence[int]) -> tuple[Ints, Ints]:
    """Return how many blocks of each level a design has, and how many of the blocks in stock to use in their place.

    Of level 0 the first has none, and the second as many as there are cells without a block.
    """
    wished = np.bincount(design.levels[~design.frame].astype(np.int64), minlength=len(owned) + 1)
    stock, wished[0] = block_counts(owned, len(wished)), 0
    stock[0] = max(int(wished.sum() - stock[1:].sum()), 0)  # cells for which there is no block
    return wished, nearest_blocks(wished, stock)


def nearest_blocks(wished: Ints, given: Ints) -> Ints:
    """Return how many of the `given` blocks of each level to use: as many as are wished in all, with the least sum of
    differences from the wished levels and, among those, the least largest difference.

    wished, given: (levels,), the latter at least as many in all. Blocks are matched in the order of their levels.
    """
    best, below = _CarriedBlocks(wished, given, len(wished)), -1
    most = len(wished)
    while most - below > 1:  # the least of the largest difference that costs no more
        tried = _CarriedBlocks(wished, given, (below + most) // 2)
        if tried.cost == best.cost:
            best, most = tried, (below + most) // 2
        else:
            below = (below + most) // 2
    return best.used()


class _CarriedBlocks:
    """The fewest blocks carried past each level on a line of levels.

    x(k) is the number of blocks used up to level k less that of cells up to it, so |x(k)| of them are carried on to, or
    from, the next level, and the sum of |x(k)| is the sum of differences. f(k, x) is the least sum up to level k:

        f(k, x) = |x| + min over the used blocks u, 0 <= u <= given(k), of f(k - 1, x - u + wished(k))

    It is convex in x, so it is kept as the places where its slope changes, left and right of where it is least: the
    minimum over u moves all places on the left by - wished(k), all on the right by given(k) - wished(k). Where each f
    is least is remembered, by which the used blocks are found from the last level back to the first.
    """

    def __init__(self, wished: Ints, given: Ints, most: int) -> None:
        """Carry with differences of at most `most`: cells up to level k - most have blocks up to level k, and blocks up
        to level k lie on cells up to level k + most.
        """
        self._wished, self._given = wished.tolist(), np.minimum(given, wished.sum()).tolist()
        self._least: list[tuple[int, int]] = []
        self._left, self._right = [(0, _ENOUGH)], [(0, _ENOUGH)]  # heaps of (place, slope); x(-1) is 0
        self._shifts = [0, 0]
        self.cost = 0
        ends = [0] * (most + 1) + np.cumsum(wished).tolist()
        ends += ends[-1:] * (most + 1)
        for k, (cells, blocks) in enumerate(zip(self._wished, self._given, strict=True)):
            left, right = self._left[0][0], self._right[0][0]  # where f(k - 1) is least
            self._least.append((self._shifts[0] - left, self._shifts[1] + right))
            self._shifts = [self._shifts[0] - cells, self._shifts[1] + blocks - cells]
            least, wished_so_far, highest = ends[k + 1], ends[k + most + 1], ends[k + 2 * most + 1]
            self._forbid(least - wished_so_far, highest - wished_so_far)
            self._add(0, 1, 1)
            self._add(0, 1, -1)
        self._forbid(0, 0)

    def used(self) -> Ints:
        """Return how many blocks of each level are used."""
        counts, x = [0] * len(self._given), 0
        for k in reversed(range(len(counts))):
            # x(k - 1) = x - u + wished(k): the nearest to where f(k - 1) is least that 0 <= u <= given(k) allows.
            low, high = self._least[k]
            before = min(max(x + self._wished[k] - self._given[k], min(x, high), low), x + self._wished[k])
            counts[k], x = x - before + self._wished[k], before
        return np.array(counts)

    def _forbid(self, low: int, high: int) -> None:
        """Let x below `low` and above `high` cost more than anything."""
        self._add(low, _ENOUGH, -1)
        self._add(high, _ENOUGH, 1)

    def _add(self, place: int, slope: int, side: int) -> None:
        """Add slope * max(side * (x - place), 0), side -1 or 1, to the function."""
        # Its place goes to the other side's heap, whose nearest places, as many as the slope, come over to this side.
        to, of = (self._right, self._left) if side > 0 else (self._left, self._right)
        shift_to, shift_of = (self._shifts[1], self._shifts[0]) if side > 0 else (self._shifts[0], self._shifts[1])
        heappush(of, (side * -(place - shift_of), slope))
        is_bound = slope == _ENOUGH
        if is_bound:  # nothing beyond it counts: what comes over is as good as at its place, and one
            heappush(to, (side * (place - shift_to), slope))
        while slope:
            at, change = heappop(of)
            moved = min(change, slope)
            if change > moved:
                heappush(of, (at, change - moved))
            nearest = side * -at + shift_of
            self.cost += moved * abs(nearest - place)
            if not is_bound:
                heappush(to, (side * (nearest - shift_to), moved))
            slope -= moved


def block_counts(owned: Sequence[int], levels: int) -> Blocks:
    """Return an inventory as an array over `levels` levels."""
    return np.array([_ENOUGH, *owned, *[0] * (levels - 1 - len(owned))], dtype=np.int64)


def lowered_to(levels: Ints, caps: Ints, left: Blocks | None) -> Ints:
    """Return levels no higher than `caps`, from the blocks that are left (changed in place); None: any number."""
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


_Cumulative = NDArray[np.int64]


class BlockCounts:
    """Possible counts of blocks, from `owned` blocks of level 0, 1, ...; with_neighbours: n(m) for m = 0 .. cells."""

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
        """Return the greatest solution below some values, if one exists."""
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
        self, field: StepField, like: Array, stream: Streams, caps: Ints | None = None, empty: int = 0
    ) -> Ints | None:
        """Return levels with about the counts of a field, as near to `like` as swaps bring them, and not above `caps`.

        They use as many blocks as `like` has above 0, or as the stock and the limit allow. None if no such order is
        found, which happens with caps alone. empty: least number of cells of level 0.
        """
        # The counts first, by the theorem on fill orders; where each block lies is then a matter of swaps.
        has_block = ~field.frame
        wished = np.bincount(field.levels[has_block], minlength=len(self.owned))
        low = np.full(len(wished), min(empty, int(has_block.sum())))
        if caps is not None:
            low = np.maximum(low, np.bincount(caps[has_block].clip(0, len(low) - 1), minlength=len(low)).cumsum())
        n = cells_with_neighbours(fill_order(has_block, like), has_block)
        counts = BlockCounts(self.owned, self.limit, n).nearest(wished, int((like[has_block] > 0).sum()), low)
        levels = np.full(field.shape, -1)
        levels[has_block] = np.repeat(np.arange(len(counts)), counts)
        arranged = rearranged_like(levels, self.limit, stream, like, caps)
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
