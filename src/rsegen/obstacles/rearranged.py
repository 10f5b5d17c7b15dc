"""Blocks in another order, in which neighbours differ by at most a given number of levels.

Two ways lead there. The first is random: blocks are swapped in pairs, as in simulated annealing with one temperature
and then none. A swap is accepted if the excess over the limit, summed over all pairs of neighbours, does not rise, and
in the first sweeps with a small probability for each level by which it rises. All cells of one colour, i + 2 j modulo
5, are swapped at once: no two of them have a common neighbour, so the effect of each swap does not depend on the
others. A sweep costs O(cells). It may fail where the limit leaves few orders: a swap moves two blocks, never a slope.
The same calls swap the blocks of thousands of maps, each by the numbers of its own stream, until the last one is right.

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
from typing import Any, NamedTuple

import numpy as np

from rsegen.field.stepfield import Array, Ints, Levels, Mask
from rsegen.params.arrays import order_of_draws
from rsegen.params.streams import Streams


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

_SWEEPS_AHEAD = 6
"""Sweeps whose numbers are drawn together, a divisor of all: each time costs as much as the numbers of three sweeps."""

_MOST_DRAWN = 2**22
"""Numbers that are drawn together for many maps: 32 MB."""

_MOST_IN_16_BITS = 2**12 - 1
"""Level up to which sums of the excess of a swap, of eight steps before and after it, fit into 16 bits."""

_NO_STEP = 32767
"""Limit of the step to a cell that is not there: none exceeds it."""


def rearranged(levels: Levels, limit: int, streams: Streams, zones: Ints | None = None) -> tuple[Levels, Mask]:
    """Return the levels of many maps, reordered so that no block differs by more than `limit` from its neighbours.

    levels: (maps, n_x, n_y), negative ones are no blocks, in all maps at the same cells. zones: (n_x, n_y), blocks stay
    within their zone, blocks with a negative zone do not move. The second is the mask of the maps for which an order
    is found; without zones, it is false only if no order exists.
    """
    result, is_done = levels.astype(np.int16), np.zeros(len(levels), dtype=bool)
    everywhere, zones = zones is None, np.zeros(levels.shape[1:], dtype=np.int64) if zones is None else zones
    left = np.arange(len(levels))
    if everywhere:  # if the ascending order is not right, none is
        ascending = _filled(levels, np.zeros(levels.shape[1:]))
        left = np.flatnonzero(_Arrangements(ascending, zones, limit).are_right())
    for times in (0, *_SMOOTHED, None):  # as drawn, ever smoother, sorted along x
        if not len(left):
            return result, is_done
        part, own = levels[left], streams.part(left)
        start = part if times == 0 else _sorted_by(_order(part.shape, times, own), part, zones)
        result[left], repaired = _repaired(_Arrangements(start, zones, limit), own, warm=times == 0)
        streams.put(left, own)
        is_done[left] = repaired
        left = left[~repaired]
    if everywhere and len(left):  # from a corner: as random as the limit allows
        part, own = levels[left], streams.part(left)
        pairs = zip(part, own.drawn(part.shape[1:]), strict=True)
        starts = [_filled(levels_of_map[None], like)[0] for levels_of_map, like in pairs]
        arrangements = _Arrangements(np.array(starts), zones, limit)
        arrangements.sweep(own, _SWEEPS)
        streams.put(left, own)
        result[left], is_done[left] = arrangements.levels(), True
    return result, is_done


def rearranged_like(levels: Ints, limit: int, stream: Streams, like: Array, caps: Ints | None = None) -> Levels | None:
    """Return levels (n_x, n_y) reordered as by `rearranged`, near the values of `like` and not above `caps`.

    like, caps: (n_x, n_y). Negative levels stay where they are, and are no blocks. None if no such order is found;
    without caps, if none exists.
    """
    one_map, zones = levels[None], np.where(levels < 0, -1, 0)
    like = like + (_smooth(like, _SMOOTHED[1]) + stream.drawn(like.shape)[0]) / 100  # ties: next to high cells first
    orders = (_smooth(like, times) for times in (0, *_SMOOTHED))
    starts = [_sorted_by(order[None], one_map, zones) for order in orders] if levels.size <= _MOST_REPAIRED else []
    for start in (*starts, _filled(one_map, like)):
        arranged, (is_right,) = _repaired(_Arrangements(start, zones, limit, like, caps), stream, warm=True)
        if is_right:
            arrangements = _Arrangements(arranged, zones, limit, like, caps)
            arrangements.sweep(stream, min(_SWEEPS, max(_MOST_SWEPT // levels.size, 1)))
            nearest: Levels = arrangements.levels()[0]
            return nearest
    return None


def _repaired(arrangements: _Arrangements, streams: Streams, *, warm: bool) -> tuple[Levels, Mask]:
    """Return the levels of all maps once swaps have made them right, or after the last sweep, and which are right.

    warm: swaps of the first half of the sweeps may make it worse.
    """
    result, repaired = arrangements.levels(), np.zeros(len(streams), dtype=bool)
    left = np.arange(len(streams))
    # Numbers are drawn for several sweeps; a map that is right before their end uses fewer, and its stream goes on
    # from there, so that it does not depend on the maps that it is made together with.
    for first in range(0, _SWEEPS, _SWEEPS_AHEAD):
        if not len(left):
            break
        rows, before = np.arange(len(left)), left
        draws = arrangements.draws_of_sweeps(streams.part(left), _SWEEPS_AHEAD)
        swept = np.full(len(left), _SWEEPS_AHEAD)
        for sweep, drawn in enumerate(draws, first):
            if (right := arrangements.are_right()).any():
                place, swept[rows[right]] = left[right], sweep - first
                result[place], repaired[place] = arrangements.levels(right), True
                arrangements.keep(~right)
                rows, left = rows[~right], left[~right]
                if not len(left):
                    break
            own = drawn if len(rows) == len(drawn) else drawn[rows]
            arrangements.swap(own, _WORSE if warm and sweep < _SWEEPS // 2 else 0.0)
        for sweeps in np.unique(swept).tolist():
            of_them = before[swept == sweeps]
            own_streams = streams.part(of_them)
            own_streams.skip(sweeps * arrangements.draws)
            streams.put(of_them, own_streams)
    result[left] = arrangements.levels()
    return result, repaired


def _order(shape: tuple[int, ...], times: int | None, streams: Streams) -> Array:
    """Return what cells are sorted by, (maps, n_x, n_y): noise smoothed `times` times, or with None the way along x."""
    if times is None:
        return np.broadcast_to(np.arange(shape[1] * shape[2], dtype=np.float64).reshape(shape[1:]), shape)
    return _smooth(streams.drawn(shape[1:]), times)


def _filled(levels: Ints, like: Array) -> Ints:
    """Return levels in ascending order along the cells from a corner, where `like` is low; frames stay.

    levels: (maps, n_x, n_y). like: (n_x, n_y).
    """
    order = fill_order(levels[0] >= 0, like)
    filled = levels.reshape(len(levels), -1).copy()
    filled[:, order] = np.sort(filled[:, order], axis=1)
    return filled.reshape(levels.shape)


def _sorted_by(order: Array, levels: Ints, zones: Ints) -> Ints:
    """Return levels (maps, n_x, n_y) sorted by `order`, alike, within each zone."""
    arranged, order = levels.reshape(len(levels), -1).copy(), order.reshape(len(levels), -1)
    for zone in np.unique(zones[zones >= 0]):
        cells = np.flatnonzero(zones == zone)
        places = cells[np.argsort(order[:, cells], axis=1, kind="stable")]
        np.put_along_axis(arranged, places, np.sort(arranged[:, cells], axis=1), axis=1)
    return arranged.reshape(levels.shape)


def _smooth(values: Array, times: int) -> Array:
    """Return values (..., n_x, n_y) of which each becomes `times` times the mean of itself and its four neighbours."""
    for _ in range(times):
        p = np.pad(values, [(0, 0)] * (values.ndim - 2) + [(1, 1)] * 2, mode="edge")
        along_x, along_y = p[..., 1:-1], p[..., 1:-1, :]
        values = (
            p[..., 1:-1, 1:-1] + along_x[..., 2:, :] + along_x[..., :-2, :] + along_y[..., 2:] + along_y[..., :-2]
        ) / 5
    return values


class _Colour(NamedTuple):
    """The movable cells of one colour, zone by zone: what the swaps of a sweep need of them.

    cells: their flat indices   places: the number of each among those drawn   zones: the part of each zone
    paired: which of the mixed cells are pairs, one cell of a pair after the other
    around: flat indices of the neighbours (4, cells)   limits: of the steps to them (4, cells, 1)
    """

    cells: Ints
    places: Ints
    zones: tuple[slice, ...]
    paired: Ints | slice
    around: Ints
    limits: Ints

    @property
    def draws(self) -> tuple[int, int]:
        """Counts of the numbers that mix the cells, and of those that are chances of pairs."""
        paired = self.paired.stop if isinstance(self.paired, slice) else len(self.paired)
        return len(self.cells), paired // 2


class _Arrangements:
    """The levels of many maps, with a border of empty cells, and the swaps between them.

    levels: (maps, n_x, n_y), in memory (cells, maps), so that a cell of all maps is a long row. like, caps: (n_x, n_y).
    """

    def __init__(
        self, levels: Ints, zones: Ints, limit: int, like: Array | None = None, caps: Ints | None = None
    ) -> None:
        maps, n_x, n_y = levels.shape
        is_low = caps is None and levels.max(initial=0) <= _MOST_IN_16_BITS
        padded = np.zeros((n_x + 2, n_y + 2, maps), dtype=np.int16 if is_low else np.int32)
        padded[1:-1, 1:-1] = np.moveaxis(levels, 0, -1)
        self._shape, self._levels = (n_x, n_y), padded.reshape(-1, maps)
        self._there = np.pad(levels[0] >= 0, 1)
        self._zones, self._limit = np.pad(zones, 1, constant_values=-1), limit
        self._like = None if like is None else np.pad(like, 1).reshape(-1, 1)
        self._caps = None if caps is None else np.pad(caps, 1).reshape(-1, 1).astype(np.int32)
        movable = np.flatnonzero(self._zones >= 0)
        colour = (movable // (n_y + 2) + 2 * (movable % (n_y + 2))) % _COLOURS
        self._colours = [self._colour(movable[colour == index]) for index in range(_COLOURS)]
        self.draws = sum(sum(colour.draws) for colour in self._colours)

    def _colour(self, cells: Ints) -> _Colour:
        """Return the cells of one colour, given in ascending order, zone by zone."""
        width = self._shape[1] + 2
        zone = self._zones.flat[cells]
        places = np.argsort(zone, kind="stable")
        cells, zone = cells[places], zone[places]
        ends = np.flatnonzero(np.diff(zone)) + 1
        parts = tuple(slice(*pair) for pair in zip([0, *ends.tolist()], [*ends.tolist(), len(cells)], strict=True))
        first = np.arange(0, len(cells) // 2 * 2, 2)
        first = first[zone[first] == zone[first + 1]]
        around = cells + np.array([1, -1, width, -width])[:, None]
        limits = np.where(self._there.flat[around], self._limit, _NO_STEP)[..., None]
        return _Colour(
            cells=cells,
            places=places,
            zones=parts,
            paired=np.stack([first, first + 1], axis=1).ravel() if len(parts) > 1 else slice(2 * len(first)),
            around=around,
            limits=limits.astype(self._levels.dtype),
        )

    def levels(self, maps: Mask | slice = slice(None)) -> Levels:
        """Return the levels of some maps without the border, (maps, n_x, n_y)."""
        n_x, n_y = self._shape
        field = self._levels[:, maps].reshape(n_x + 2, n_y + 2, -1)[1:-1, 1:-1]
        return np.moveaxis(field, -1, 0).astype(np.int16)

    def keep(self, maps: Mask) -> None:
        """Leave out all maps but some."""
        self._levels = np.ascontiguousarray(self._levels[:, maps])

    def are_right(self) -> Mask:
        """Return whether every movable block of each map is within the limit of its neighbours, (maps,)."""
        n_x, n_y = self._shape
        field, movable = self._levels.reshape(n_x + 2, n_y + 2, -1), self._zones >= 0
        right = np.ones(field.shape[2], dtype=bool)
        for low, high in ((np.s_[:-1], np.s_[1:]), (np.s_[:, :-1], np.s_[:, 1:])):
            is_step = self._there[low] & self._there[high] & (movable[low] | movable[high])
            most = np.where(is_step, self._limit, _NO_STEP).astype(field.dtype)[..., None]
            right &= ~(np.abs(field[high] - field[low]) > most).any(axis=(0, 1))
        if self._caps is not None:
            right &= ~(self._levels > self._caps)[movable.ravel()].any(axis=0)
        return right

    def draws_of_sweeps(self, streams: Streams, sweeps: int) -> Iterator[Array]:
        """Yield the next numbers of every map for each of some sweeps, (maps, draws); the streams stay there."""
        streams = streams.copy()
        at_once = max(min(_MOST_DRAWN // max(len(streams) * self.draws, 1), sweeps), 1)
        for first in range(0, sweeps, at_once):
            yield from np.moveaxis(streams.drawn((min(at_once, sweeps - first), self.draws)), 1, 0)

    def sweep(self, streams: Streams, sweeps: int) -> None:
        """Swap pairs of blocks in some sweeps, without any swap that makes it worse."""
        for drawn in self.draws_of_sweeps(streams, sweeps):
            self.swap(drawn, 0.0)
        streams.skip(sweeps * self.draws)

    def swap(self, drawn: Array, worse: float) -> None:
        """Swap random pairs if that makes nothing worse, and by the probability `worse` per level if it does.

        Swaps that make it neither worse nor better are left out if they lead away from `like`. drawn: (maps, draws).
        """
        probabilities: Any = np.cumprod([1.0, *[worse] * _MOST_WORSE])
        start = 0
        for colour in self._colours:
            cells, pairs = colour.draws
            numbers, chances = np.split(drawn[:, start : start + cells + pairs], [cells], axis=1)
            start += cells + pairs
            if pairs:
                self._swap(colour, numbers, chances, probabilities)

    def _swap(self, colour: _Colour, numbers: Array, chances: Array, probabilities: Array) -> None:
        """Swap pairs of cells of one colour and zone, mixed by their numbers (maps, cells)."""
        maps = len(numbers)
        places = _mixed(colour, numbers).T[colour.paired] * maps + np.arange(maps)  # flat indices into (cells, maps)
        before, around = self._levels[colour.cells], self._levels[colour.around]
        old = before.ravel().take(places)
        new = old.reshape(-1, 2, maps)[:, ::-1].reshape(old.shape)
        after = before.copy()
        after.ravel()[places] = new
        rises = self._excess(colour, after, around) - self._excess(colour, before, around)
        rise = _of_pairs(rises, places)
        swapped = rise <= 0
        # Only few chances are below the probability of the smallest rise.
        lucky, pair = np.nonzero(chances < probabilities[1])
        risen = rise[pair, lucky]
        swapped[pair, lucky] |= chances[lucky, pair] < probabilities[np.clip(risen, 0, _MOST_WORSE)]
        if self._like is not None:
            like = self._like[colour.cells]
            farther, nearer = (_of_pairs(np.abs(levels - like), places) for levels in (before, after))
            swapped &= (rise != 0) | (nearer <= farther)
        before.ravel()[places] = np.where(np.repeat(swapped, 2, axis=0), new, old)
        self._levels[colour.cells] = before

    def _excess(self, colour: _Colour, levels: Ints, around: Ints) -> Any:
        """Return by how many levels each cell (cells, maps), with these levels, exceeds its limits: steps, cap.

        around: the levels of its neighbours, (4, cells, maps).
        """
        steps = around - levels
        np.abs(steps, out=steps)
        steps -= np.minimum(steps, colour.limits)
        excess = (steps[0] + steps[1]) + (steps[2] + steps[3])
        return excess if self._caps is None else excess + np.maximum(levels - self._caps[colour.cells], 0)


def _of_pairs(values: Any, places: Ints) -> Any:
    """Return the sum of the values of both cells of each pair, (pairs, maps)."""
    own = values.ravel().take(places)
    return own[::2] + own[1::2]


def _mixed(colour: _Colour, numbers: Array) -> Ints:
    """Return the cells of each map in the order of their numbers (maps, cells), zone after zone: places."""
    if len(colour.zones) == 1:
        return order_of_draws(numbers)  # type: ignore[no-any-return]  # an array as the numbers
    return np.concatenate([order_of_draws(numbers[:, colour.places[part]]) + part.start for part in colour.zones], 1)
