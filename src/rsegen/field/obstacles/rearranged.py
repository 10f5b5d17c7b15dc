"""The same blocks in another order, in which neighbours differ by at most a given number of levels.

Blocks are swapped in pairs by simulated annealing. All cells of one colour, i + 2 j modulo 5, are swapped at once: no
two of them have a common neighbour, so the effect of each swap does not depend on the others.

The order in which sorted blocks fill a field with the smallest steps: diagonal by diagonal from a corner.

If any arrangement of some blocks keeps to a largest step, the ascending one along this order does. Of all sets of so
many cells of a rectangle, the first cells of this order have the fewest neighbours, and with their neighbours they are
the first cells again (Bollobás and Leader 1991, "Compressions and isoperimetric inequalities"). Rectangles of equal
size between frames are filled one after another. The tests compare it with all arrangements on small grids.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product, starmap

import numpy as np

from rsegen.field.stepfield import Array, Ints, Levels, Mask


def fill_order(there: Mask, like: Array) -> Ints:
    """Flat indices of the cells of a mask (n_x, n_y) in this order, those with low values of `like` rather first.

    Each rectangle that the frames leave begins at the corner that fits best, lower rectangles before higher ones.
    """
    parts = [
        _from_best_corner(np.arange(there.size).reshape(there.shape)[part], like[part])
        for part in starmap(np.ix_, product(*(_runs(np.asarray(there.any(axis=axis))) for axis in (1, 0))))
    ]
    lowest_first = np.argsort([like.flat[part].mean() for part in parts], kind="stable")
    return np.concatenate([parts[number] for number in lowest_first])


def cells_with_neighbours(order: Ints, there: Mask) -> Ints:
    """How many cells from the first of an order on contain the first m and their neighbours, for m = 0 .. all."""
    place = np.full((there.shape[0] + 2, there.shape[1] + 2), -1)
    inner = place[1:-1, 1:-1]
    inner[np.unravel_index(order, there.shape)] = np.arange(len(order))
    around = (place[2:, 1:-1], place[:-2, 1:-1], place[1:-1, 2:], place[1:-1, :-2])
    last = np.maximum.reduce([inner, *around]).flat[order]
    return np.concatenate([[0], np.maximum.accumulate(last) + 1])


def _runs(lines: Mask) -> list[Ints]:
    """The lines that are true, as runs of successive ones."""
    found = np.flatnonzero(lines)
    return np.split(found, np.flatnonzero(np.diff(found) > 1) + 1)


def _from_best_corner(cells: Ints, like: Array) -> Ints:
    """The cells of a rectangle diagonal by diagonal, from the corner for which `like` rises most along them."""
    n_x, n_y = cells.shape
    i, j = (at.ravel() for at in np.indices((n_x, n_y)))
    diagonals = np.lexsort((-i if n_x <= n_y else -j, i + j))  # along the other way rectangles need larger steps
    flips = [(slice(None, None, x), slice(None, None, y)) for x, y in product((1, -1), repeat=2)]
    rising = np.arange(cells.size) - (cells.size - 1) / 2
    best = max(flips, key=lambda flip: float(rising @ like[flip].ravel()[diagonals]))
    return cells[best].ravel()[diagonals]


_COLOURS = 5
_SWEEPS = 120
_WORSE = 0.03
"""Probability of a swap that makes the order worse by one level, in the first sweeps: it leaves local minima."""

_SMOOTHED = (1, 4, 16, 64)
"""If the order that was drawn cannot be repaired, blocks are sorted by random noise that was smoothed this often."""

_MOST_REPAIRED = 2**16
"""Cells above which a field is filled from a corner at once, as repairing it would take minutes."""

_MOST_SWEPT = 2**23
"""Cells of all sweeps together that bring a field nearer to another one."""


def rearranged(levels: Ints, limit: int, rng: np.random.Generator, zones: Ints | None = None) -> Levels | None:
    """Levels (n_x, n_y) reordered so that no block differs by more than `limit` from its four neighbours.

    zones: (n_x, n_y), blocks stay within their zone, those with a negative zone do not move; a negative level is no
    block. Returns None if no such order is found; without zones, if there is none.
    """
    levels = levels.astype(np.int64)
    everywhere, zones = zones is None, np.zeros_like(levels) if zones is None else zones
    if everywhere and not _Grid(_filled(levels, np.zeros(levels.shape)), zones, limit).is_right():
        return None
    for warm, start in _starts(levels, zones, rng):
        if grid := _repaired(_Grid(start, zones, limit), rng, warm=warm):
            return grid.levels()
    if not everywhere:
        return None
    grid = _Grid(_filled(levels, rng.random(levels.shape)), zones, limit)
    for _ in range(_SWEEPS):  # as random as the limit allows
        grid.swap(rng, 0.0)
    return grid.levels()


def rearranged_like(
    levels: Ints, limit: int, rng: np.random.Generator, like: Array, caps: Ints | None = None
) -> Levels | None:
    """Levels (n_x, n_y) reordered as by `rearranged`, near the values of `like` and not above `caps`, (n_x, n_y) each.

    Negative levels stay where they are, and are no blocks. Returns None if no such order is found; without caps, if
    there is none.
    """
    zones = np.where(levels < 0, -1, 0)
    like = like + (_smooth(like, _SMOOTHED[1]) + rng.random(like.shape)) / 100  # of equal cells, those beside high ones
    orders = (_smooth(like, times) for times in (0, *_SMOOTHED))
    starts = [_sorted_by(order, levels, zones) for order in orders] if levels.size <= _MOST_REPAIRED else []
    for start in (*starts, _filled(levels, like)):
        if grid := _repaired(_Grid(start, zones, limit, like, caps), rng, warm=True):
            for _ in range(min(_SWEEPS, max(_MOST_SWEPT // levels.size, 1))):
                grid.swap(rng, 0.0)
            return grid.levels()
    return None


def _repaired(grid: _Grid, rng: np.random.Generator, *, warm: bool) -> _Grid | None:
    """The grid when swaps have made it right; None if they do not. `warm`: the first half may make it worse."""
    for sweep in range(_SWEEPS):
        if grid.is_right():
            return grid
        grid.swap(rng, _WORSE if warm and sweep < _SWEEPS // 2 else 0.0)
    return None


def _starts(levels: Ints, zones: Ints, rng: np.random.Generator) -> Iterator[tuple[bool, Ints]]:
    """Initial orders and whether worse swaps are allowed: as drawn, ever smoother ones, and sorted along x."""
    yield True, levels
    for times in _SMOOTHED:
        yield False, _sorted_by(_smooth(rng.random(levels.shape), times), levels, zones)
    yield False, _sorted_by(np.arange(levels.size, dtype=np.float64).reshape(levels.shape), levels, zones)


def _filled(levels: Ints, like: Array) -> Ints:
    """Levels in ascending order along the cells from a corner, where `like` is low; frames stay."""
    order = fill_order(levels >= 0, like)
    found = levels.copy()
    found.flat[order] = np.sort(levels.flat[order])
    return found


def _sorted_by(order: Array, levels: Ints, zones: Ints) -> Ints:
    """Levels sorted by `order` within each zone."""
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
    """The levels as a flat array with a border of empty cells, and the swaps between them."""

    def __init__(
        self, levels: Ints, zones: Ints, limit: int, like: Array | None = None, caps: Ints | None = None
    ) -> None:
        self._shape = levels.shape
        self._limit = limit
        self._levels = np.pad(levels, 1).ravel()
        self._there = np.pad(levels >= 0, 1).ravel()
        self._like = None if like is None else np.pad(like, 1).ravel()
        self._caps = None if caps is None else np.pad(caps, 1).ravel()
        self._zones = np.pad(zones, 1, constant_values=-1).ravel()
        width = levels.shape[1] + 2
        self._beside = np.array([1, -1, width, -width])
        self._movable = np.flatnonzero(self._zones >= 0)
        colour = (self._movable // width + 2 * (self._movable % width)) % _COLOURS
        self._colours = [self._movable[colour == each] for each in range(_COLOURS)]

    def levels(self) -> Levels:
        """The levels without the border, (n_x, n_y)."""
        n_x, n_y = self._shape
        return self._levels.reshape(n_x + 2, n_y + 2)[1:-1, 1:-1].astype(np.int16)

    def is_right(self) -> bool:
        """Whether every movable block is within the limit of its neighbours."""
        return not self._amiss(self._movable, self._levels[self._movable]).any()

    def swap(self, rng: np.random.Generator, worse: float) -> None:
        """Swap random pairs if that does no harm, and with a small probability if it does.

        Swaps that do neither harm nor good are left out if they lead away from `like`.
        """
        chances = np.cumprod([1.0, *[worse] * 8])
        for cells in self._colours:
            one, other = self._pairs(cells, rng)
            if not len(one):
                continue
            harm = self._harm(one, other)
            swapped = rng.random(len(one)) < chances[np.clip(harm, 0, len(chances) - 1)]
            if self._like is not None:
                swapped &= (harm != 0) | ~self._is_farther(self._like, one, other)
            one, other = one[swapped], other[swapped]
            self._levels[one], self._levels[other] = self._levels[other], self._levels[one]

    def _is_farther(self, like: Array, one: Ints, other: Ints) -> Mask:
        """Whether each swap makes two blocks differ more from `like` in sum."""
        a, b = self._levels[one], self._levels[other]
        before, after = ((np.abs(x - like[one]) + np.abs(y - like[other])) for x, y in ((a, b), (b, a)))
        return np.asarray(after > before)

    def _harm(self, one: Ints, other: Ints) -> Ints:
        """By how many levels more in sum the limit would be exceeded after each swap."""
        was, is_to_be = self._levels[one], self._levels[other]
        pairs, swaps = np.concatenate([one, other]), np.concatenate([is_to_be, was, was, is_to_be])
        amiss = self._amiss(np.tile(pairs, 2), swaps).reshape(4, len(one))  # at once: most grids are small
        return np.asarray(amiss[0] + amiss[1] - amiss[2] - amiss[3])

    def _pairs(self, cells: Ints, rng: np.random.Generator) -> tuple[Ints, Ints]:
        """Random pairs of cells of one zone; some cells are left over."""
        mixed = cells[np.argsort(rng.random(len(cells)), kind="stable")]
        mixed = mixed[np.argsort(self._zones[mixed], kind="stable")]
        even = len(mixed) // 2 * 2
        one, other = mixed[:even:2], mixed[1:even:2]
        alike = self._zones[one] == self._zones[other]
        return one[alike], other[alike]

    def _amiss(self, cells: Ints, levels: Ints) -> Ints:
        """By how many levels in sum each cell would exceed the limit to its neighbours if it had these levels."""
        beside = cells[:, None] + self._beside
        differs = np.abs(self._levels[beside] - levels[:, None]) - self._limit
        amiss = (np.maximum(differs, 0) * self._there[beside]).sum(axis=1)
        return np.asarray(amiss if self._caps is None else amiss + np.maximum(levels - self._caps[cells], 0))
