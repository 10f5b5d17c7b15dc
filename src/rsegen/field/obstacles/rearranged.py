"""The same blocks in another order, so that no two neighbours differ by more than so many levels.

Blocks are swapped in pairs. In one go all those of a colour i + 2 j modulo 5 may be: no two of them have a neighbour in
common, so each swap knows what it does, whatever the others do.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from rsegen.field.stepfield import Array, Ints, Levels

_COLOURS = 5
_SWEEPS = 120
_WORSE = 0.03
"""How often a swap is made that makes matters worse by one level, at first: else the last knots are not untied."""

_SMOOTHED = (1, 4, 16, 64)
"""How many times chance is smoothed before blocks are sorted by it, where the order that was drawn cannot be mended."""


def rearranged(levels: Ints, limit: int, rng: np.random.Generator, zones: Ints | None = None) -> Levels | None:
    """Levels (n_x, n_y) in an order in which no block differs by more than `limit` from the four beside it.

    Blocks stay within their zone, (n_x, n_y); those of a negative one do not move, and a negative level is none. None
    where no such order is found.
    """
    zones = np.zeros(levels.shape, dtype=np.int64) if zones is None else zones
    for warm, start in _starts(levels.astype(np.int64), zones, rng):
        grid = _Grid(start, zones, limit)
        for sweep in range(_SWEEPS):
            if grid.is_right():
                return grid.levels()
            grid.swap(rng, _WORSE if warm and sweep < _SWEEPS // 2 else 0.0)
    return None


def _starts(levels: Ints, zones: Ints, rng: np.random.Generator) -> Iterator[tuple[bool, Ints]]:
    """Orders to begin with, whether they may get worse at first: as drawn, ever smoother ones, and in line along x."""
    yield True, levels
    for times in _SMOOTHED:
        yield False, _sorted_by(_smooth(rng.random(levels.shape), times), levels, zones)
    yield False, _sorted_by(np.arange(levels.size, dtype=np.float64).reshape(levels.shape), levels, zones)


def _sorted_by(order: Array, levels: Ints, zones: Ints) -> Ints:
    """Levels rise as `order` does, within each zone."""
    found = levels.copy()
    for zone in np.unique(zones[zones >= 0]):
        cells = np.flatnonzero(zones == zone)
        found.flat[cells[np.argsort(order.flat[cells], kind="stable")]] = np.sort(levels.flat[cells])
    return found


def _smooth(values: Array, times: int) -> Array:
    for _ in range(times):
        p = np.pad(values, 1, mode="edge")
        values = (p[1:-1, 1:-1] + p[2:, 1:-1] + p[:-2, 1:-1] + p[1:-1, 2:] + p[1:-1, :-2]) / 5
    return values


class _Grid:
    """Levels with a rim of nothing round them, as one row."""

    def __init__(self, levels: Ints, zones: Ints, limit: int) -> None:
        self._shape = levels.shape
        self._limit = limit
        self._levels = np.pad(levels, 1).ravel()
        self._there = np.pad(levels >= 0, 1).ravel()
        self._zones = np.pad(zones, 1, constant_values=-1).ravel()
        width = levels.shape[1] + 2
        self._beside = np.array([1, -1, width, -width])
        self._movable = np.flatnonzero(self._zones >= 0)
        colour = (self._movable // width + 2 * (self._movable % width)) % _COLOURS
        self._colours = [self._movable[colour == each] for each in range(_COLOURS)]

    def levels(self) -> Levels:
        """(n_x, n_y)."""
        n_x, n_y = self._shape
        return self._levels.reshape(n_x + 2, n_y + 2)[1:-1, 1:-1].astype(np.int16)

    def is_right(self) -> bool:
        """Whether no block that may move differs too much."""
        return not self._amiss(self._movable, self._levels[self._movable]).any()

    def swap(self, rng: np.random.Generator, worse: float) -> None:
        """Swap pairs at random: where it does no harm, and at times where it does."""
        chances = np.cumprod([1.0, *[worse] * 8])
        for cells in self._colours:
            one, other = self._pairs(cells, rng)
            was, is_to_be = self._levels[one], self._levels[other]
            harm = self._amiss(one, is_to_be) + self._amiss(other, was) - self._amiss(one, was)
            harm = np.clip(harm - self._amiss(other, is_to_be), 0, len(chances) - 1)
            swapped = rng.random(len(one)) < chances[harm]
            self._levels[one[swapped]] = is_to_be[swapped]
            self._levels[other[swapped]] = was[swapped]

    def _pairs(self, cells: Ints, rng: np.random.Generator) -> tuple[Ints, Ints]:
        """Two by two of one zone, at random; some are left over."""
        mixed = cells[np.argsort(rng.random(len(cells)), kind="stable")]
        mixed = mixed[np.argsort(self._zones[mixed], kind="stable")]
        even = len(mixed) // 2 * 2
        one, other = mixed[:even:2], mixed[1:even:2]
        alike = self._zones[one] == self._zones[other]
        return one[alike], other[alike]

    def _amiss(self, cells: Ints, levels: Ints) -> Ints:
        """By how many levels too much each cell, were it of such a level, differs from its neighbours."""
        beside = cells[:, None] + self._beside
        differs = np.abs(self._levels[beside] - levels[:, None]) - self._limit
        return np.asarray((np.maximum(differs, 0) * self._there[beside]).sum(axis=1))
