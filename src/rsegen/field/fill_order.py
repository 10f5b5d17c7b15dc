"""The order in which sorted blocks fill a field with the smallest steps: diagonal by diagonal from a corner.

If any arrangement of some blocks keeps to a largest step, the ascending one along this order does. Of all sets of so
many cells of a rectangle, the first cells of this order have the fewest neighbours, and with their neighbours they are
the first cells again (Bollobás and Leader 1991, "Compressions and isoperimetric inequalities"). Rectangles of equal
size between frames are filled one after another. The tests compare it with all arrangements on small grids.
"""

from __future__ import annotations

from itertools import product, starmap

import numpy as np

from rsegen.field.stepfield import Array, Ints, Mask


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
