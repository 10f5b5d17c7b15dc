"""How many blocks of each level a field can have whose neighbours differ by a limit at most, from the blocks in stock.

With a_t the number of cells up to level t, c_t the blocks in stock of level t, and n(a) the cells that the first a
cells of a fill order and their neighbours take up (field/fill_order.py), the counts are possible if and only if

    a_t <= a_(t+1) <= a_t + c_(t+1),    n(a_t) <= a_(t+limit),    a of the highest level = all cells.

All of it has the form "one is at least a rising function of another", so there is a least solution above given values,
and a greatest one below: both are found by raising, or lowering, what is not right yet.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rsegen.field.stepfield import Ints

_Cumulative = NDArray[np.int64]


class BlockCounts:
    """The counts that are possible, from `owned` blocks of level 0, 1, ...; with_neighbours: n(m) for m = 0 .. all."""

    def __init__(self, owned: Ints, limit: int, with_neighbours: Ints) -> None:
        self._cells = len(with_neighbours) - 1
        self._stock = np.minimum(np.concatenate([[0], owned[1:]]), self._cells).cumsum()
        self._limit = limit
        self._n = with_neighbours

    def nearest(self, wished: Ints, blocks: int, lowest: Ints) -> Ints:
        """Possible counts of level 0, 1, ... near `wished`, with at least so many `blocks`, or as many as possible.

        lowest: for each level, the least number of cells that are no higher.
        """
        most = np.full(len(wished), self._cells)
        most[0] = max(self._cells - blocks, self._least(lowest)[0])
        wish = np.minimum(np.cumsum(wished), self._greatest(most))
        return np.diff(self._least(np.maximum(wish, lowest)), prepend=0)

    def _least(self, values: Ints) -> _Cumulative:
        """The least solution above some values: with the fewest low blocks, so with the most blocks."""
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
        """The greatest solution below some values, above which there is one."""
        greatest = values
        while True:
            before = greatest
            greatest = np.minimum.accumulate(greatest[::-1])[::-1]
            within = np.searchsorted(self._n, greatest[self._limit :], side="right") - 1
            greatest[: -self._limit] = np.minimum(greatest[: -self._limit], within)
            greatest = self._stock + np.minimum.accumulate(greatest - self._stock)
            if (greatest == before).all():
                return np.asarray(greatest)
