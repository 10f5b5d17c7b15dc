"""The highest block under a shape of cells, for all of its places at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from rsegen.field.stepfield import Array, Mask

Run: TypeAlias = tuple[int, int, int]
"""Cells of a shape that are next to each other along y: index along x, first index along y, number."""


def runs(shape: Mask) -> Sequence[Run]:
    """The runs of cells that a shape consists of."""
    padded = np.pad(shape.astype(np.int8), ((0, 0), (1, 1)))
    change = np.diff(padded, axis=1)
    starts, ends = np.argwhere(change == 1), np.argwhere(change == -1)
    return [(int(i), int(low), int(high - low)) for (i, low), (_, high) in zip(starts, ends, strict=True)]


@dataclass(frozen=True, kw_only=True, slots=True)
class Maxima:
    """The maxima of an array over 1, 2, 4, ... cells along y, of which the maximum over any run is made."""

    tables: tuple[Array, ...]

    @classmethod
    def of(cls, values: Array, longest: int) -> Maxima:
        """Those of values, for runs of up to this many cells."""
        tables, covered = [values], 1
        while 2 * covered <= min(longest, values.shape[1]):
            tables.append(np.maximum(tables[-1][:, :-covered], tables[-1][:, covered:]))
            covered *= 2
        return cls(tables=tuple(tables))

    def over(self, found: Mask, shape: tuple[int, ...]) -> Array:
        """The maximum over cells, placed at each of the first `shape` cells of the array; -inf over none."""
        highest = np.full(shape, -np.inf)
        for i, low, cells in runs(found):
            level = cells.bit_length() - 1
            table = self.tables[level]
            for j in {low, low + cells - 2**level}:
                np.maximum(highest, table[i : i + shape[0], j : j + shape[1]], out=highest)
        return highest
