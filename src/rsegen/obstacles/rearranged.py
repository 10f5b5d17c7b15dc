"""Blocks in another order, in which neighbours differ by at most a given number of levels.

Two ways lead there. The first is random: blocks are swapped in pairs, as in simulated annealing with one temperature
and then none. A swap is accepted if the excess over the limit, summed over all pairs of neighbours, does not rise, and
in the first sweeps with a small probability for each level by which it rises. All cells of one colour, i + 2 j modulo
5, are swapped at once: no two of them have a common neighbour, so the effect of each swap does not depend on the
others. A sweep costs O(cells). It may fail where the limit leaves few orders: a swap moves two blocks, never a slope.

The second is sure: sorted blocks fill a field diagonal by diagonal from a corner (`fill_order`). If any arrangement of
some blocks keeps to a largest step, the ascending one along this order does. Of all sets of m cells of a rectangle, the
first m of this order have the fewest neighbours, and with their neighbours they are the first cells again (Bollobás and
Leader 1991, "Compressions and isoperimetric inequalities"). Rectangles of equal size between frames are filled one
after another. So this order decides whether there is a solution at all; zones and caps, which it does not know, break
that. The tests compare it with all arrangements on small grids.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product, starmap

import numpy as np

from rsegen.field.stepfield import Array, Ints, Levels, Mask


def fill_order(there: Mask, like: Array) -> Ints:
    """Return flat indices of the cells of a mask (n_x, n_y) by diagonals, low values of `like` first where possible.

    Each rectangle that the frames leave begins at the corner that fits best, lower rectangles before higher ones.
    """
    parts = [
        _from_best_corner(np.arange(there.size).reshape(there.shape)[part], like[part])
        for part in starmap(np.ix_, product(*(_runs(np.asarray(there.any(axis=axis))) for axis in (1, 0))))
    ]
    lowest_first = np.argsort([like.flat[part].mean() for part in parts], kind="stable")
    return np.concatenate([parts[index] for index in lowest_first])


def cells_with_neighbours(order: Ints, there: Mask) -> Ints:
    """Return for m = 0 .. all how many first cells of an order contain the first m cells and their neighbours."""
    place = np.full((there.shape[0] + 2, there.shape[1] + 2), -1)
    inner = place[1:-1, 1:-1]
    inner[np.unravel_index(order, there.shape)] = np.arange(len(order))
    around = (place[2:, 1:-1], place[:-2, 1:-1], place[1:-1, 2:], place[1:-1, :-2])
    last = np.maximum.reduce([inner, *around]).flat[order]
    return np.concatenate([[0], np.maximum.accumulate(last) + 1])


def _runs(lines: Mask) -> list[Ints]:
    """Return the indices of lines that are true, as runs of successive ones."""
    indices = np.flatnonzero(lines)
    return np.split(indices, np.flatnonzero(np.diff(indices) > 1) + 1)


def _from_best_corner(cells: Ints, like: Array) -> Ints:
    """Return the cells of a rectangle diagonal by diagonal, from the corner for which `like` rises most along them."""
    n_x, n_y = cells.shape
    i, j = (at.ravel() for at in np.indices((n_x, n_y)))
    diagonals = np.lexsort((-i if n_x <= n_y else -j, i + j))  # along the other way rectangles need larger steps
    flips = [(slice(None, None, x), slice(None, None, y)) for x, y in product((1, -1), repeat=2)]
    rising = np.arange(cells.size) - (cells.size - 1) / 2
    best = max(flips, key=lambda flip: float(rising @ like[flip].ravel()[diagonals]))
    return cells[best].ravel()[diagonals]


_COLOURS = 5
"""Fewest colours of which no two cells of one have a common neighbour: a cell and its four neighbours all differ."""

_SWEEPS = 120
"""Sweeps of one attempt at a repair; if they do not suffice, the next initial order is tried."""

_WORSE = 0.03
"""Probability of a swap that makes the order worse by one level, in the first sweeps: it leaves local minima."""

_MOST_WORSE = 8
"""Levels by which a swap may make the order worse; above, the probability is that of this number: below 1e-12."""

_SMOOTHED = (1, 4, 16, 64)
"""Times that random noise is smoothed, by which blocks are sorted if the order that was drawn cannot be repaired.

The hills of noise widen with the root of this number, so each attempt has gentler slopes than the last.
"""

_MOST_REPAIRED = 2**16
"""Cells above which a field is filled from a corner without an attempt at repair, which would take minutes."""

_MOST_SWEPT = 2**23
"""Cells, over all sweeps, that may be swapped to bring a field nearer to another one: it bounds the time."""


def rearranged(levels: Ints, limit: int, rng: np.random.Generator, zones: Ints | None = None) -> Levels | None:
    """Return levels (n_x, n_y) reordered so that no block differs by more than `limit` from its four neighbours.

    zones: (n_x, n_y), blocks stay within their zone, those with a negative zone do not move; a negative level is no
    block. None if no such order is found; without zones, if there is none.
    """
    levels = levels.astype(np.int64)
    everywhere, zones = zones is None, np.zeros_like(levels) if zones is None else zones
    if everywhere and not _Arrangement(_filled(levels, np.zeros(levels.shape)), zones, limit).is_right():
        return None  # no order of these blocks is right, as the ascending one is not
    for warm, start in _starts(levels, zones, rng):
        if arrangement := _repaired(_Arrangement(start, zones, limit), rng, warm=warm):
            return arrangement.levels()
    if not everywhere:
        return None
    arrangement = _Arrangement(_filled(levels, rng.random(levels.shape)), zones, limit)
    for _ in range(_SWEEPS):  # as random as the limit allows
        arrangement.swap(rng, 0.0)
    return arrangement.levels()


def rearranged_like(
    levels: Ints, limit: int, rng: np.random.Generator, like: Array, caps: Ints | None = None
) -> Levels | None:
    """Return levels (n_x, n_y) reordered as by `rearranged`, near the values of `like` and not above `caps`.

    like, caps: (n_x, n_y). Negative levels stay where they are, and are no blocks. None if no such order is found;
    without caps, if there is none.
    """
    zones = np.where(levels < 0, -1, 0)
    like = like + (_smooth(like, _SMOOTHED[1]) + rng.random(like.shape)) / 100  # ties: next to high cells first
    orders = (_smooth(like, times) for times in (0, *_SMOOTHED))
    starts = [_sorted_by(order, levels, zones) for order in orders] if levels.size <= _MOST_REPAIRED else []
    for start in (*starts, _filled(levels, like)):
        if arrangement := _repaired(_Arrangement(start, zones, limit, like, caps), rng, warm=True):
            for _ in range(min(_SWEEPS, max(_MOST_SWEPT // levels.size, 1))):
                arrangement.swap(rng, 0.0)
            return arrangement.levels()
    return None


def _repaired(arrangement: _Arrangement, rng: np.random.Generator, *, warm: bool) -> _Arrangement | None:
    """Return the arrangement once swaps have made it right; None if they do not.

    warm: swaps of the first half of the sweeps may make it worse.
    """
    for sweep in range(_SWEEPS):
        if arrangement.is_right():
            return arrangement
        arrangement.swap(rng, _WORSE if warm and sweep < _SWEEPS // 2 else 0.0)
    return None


def _starts(levels: Ints, zones: Ints, rng: np.random.Generator) -> Iterator[tuple[bool, Ints]]:
    """Yield whether worse swaps are allowed, and an initial order: as drawn, ever smoother ones, sorted along x."""
    yield True, levels
    for times in _SMOOTHED:
        yield False, _sorted_by(_smooth(rng.random(levels.shape), times), levels, zones)
    yield False, _sorted_by(np.arange(levels.size, dtype=np.float64).reshape(levels.shape), levels, zones)


def _filled(levels: Ints, like: Array) -> Ints:
    """Return levels in ascending order along the cells from a corner, where `like` is low; frames stay."""
    order = fill_order(levels >= 0, like)
    filled = levels.copy()
    filled.flat[order] = np.sort(levels.flat[order])
    return filled


def _sorted_by(order: Array, levels: Ints, zones: Ints) -> Ints:
    """Return levels sorted by `order` within each zone."""
    arranged = levels.copy()
    for zone in np.unique(zones[zones >= 0]):
        cells = np.flatnonzero(zones == zone)
        arranged.flat[cells[np.argsort(order.flat[cells], kind="stable")]] = np.sort(levels.flat[cells])
    return arranged


def _smooth(values: Array, times: int) -> Array:
    """Return values of which each is, so many times, the mean of itself and its four neighbours."""
    for _ in range(times):
        p = np.pad(values, 1, mode="edge")
        values = (p[1:-1, 1:-1] + p[2:, 1:-1] + p[:-2, 1:-1] + p[1:-1, 2:] + p[1:-1, :-2]) / 5
    return values


class _Arrangement:
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
        self._neighbours = np.array([1, -1, width, -width])  # as offsets of flat indices
        self._movable = np.flatnonzero(self._zones >= 0)
        colour = (self._movable // width + 2 * (self._movable % width)) % _COLOURS
        self._cells_by_colour = [self._movable[colour == index] for index in range(_COLOURS)]

    def levels(self) -> Levels:
        """Return the levels without the border, (n_x, n_y)."""
        n_x, n_y = self._shape
        return self._levels.reshape(n_x + 2, n_y + 2)[1:-1, 1:-1].astype(np.int16)

    def is_right(self) -> bool:
        """Return whether every movable block is within the limit of its neighbours."""
        return not self._excess(self._movable, self._levels[self._movable]).any()

    def swap(self, rng: np.random.Generator, worse: float) -> None:
        """Swap random pairs if that makes nothing worse, and by the probability `worse` per level if it does.

        Swaps that make it neither worse nor better are left out if they lead away from `like`.
        """
        probabilities = np.cumprod([1.0, *[worse] * _MOST_WORSE])
        for cells in self._cells_by_colour:
            a, b = self._pairs(cells, rng)
            if not len(a):
                continue
            of_a, of_b = self._levels[a], self._levels[b]
            # After each swap, and before it: at once, as grids are small.
            levels = np.concatenate([of_b, of_a, of_a, of_b])
            excess = self._excess(np.concatenate([a, b, a, b]), levels).reshape(4, len(a))
            rise = excess[0] + excess[1] - excess[2] - excess[3]
            swapped = rng.random(len(a)) < probabilities[np.clip(rise, 0, _MOST_WORSE)]
            if (like := self._like) is not None:
                before, after = (np.abs(x - like[a]) + np.abs(y - like[b]) for x, y in ((of_a, of_b), (of_b, of_a)))
                swapped &= (rise != 0) | (after <= before)
            a, b, of_a, of_b = a[swapped], b[swapped], of_a[swapped], of_b[swapped]
            self._levels[a], self._levels[b] = of_b, of_a

    def _pairs(self, cells: Ints, rng: np.random.Generator) -> tuple[Ints, Ints]:
        """Return random pairs of cells of one zone; some cells are left over."""
        mixed = cells[np.argsort(rng.random(len(cells)), kind="stable")]
        mixed = mixed[np.argsort(self._zones[mixed], kind="stable")]
        even = len(mixed) // 2 * 2
        a, b = mixed[:even:2], mixed[1:even:2]
        alike = self._zones[a] == self._zones[b]
        return a[alike], b[alike]

    def _excess(self, cells: Ints, levels: Ints) -> Ints:
        """Return by how many levels each cell, with these levels, would exceed its limits: steps and cap, in sum."""
        neighbours = cells[:, None] + self._neighbours
        beyond = np.abs(self._levels[neighbours] - levels[:, None]) - self._limit
        excess = (np.maximum(beyond, 0) * self._there[neighbours]).sum(axis=1)
        return np.asarray(excess if self._caps is None else excess + np.maximum(levels - self._caps[cells], 0))
