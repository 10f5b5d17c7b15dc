"""The fewest rectangles that a grid can be cut into: slow and plain, from another direction than what it judges."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import maximum_bipartite_matching

Corner = tuple[int, int]
Grid = tuple[tuple[int, ...], ...]


def searched(labels: np.ndarray) -> int:
    """By trying everything: for grids of a dozen squares."""

    @cache
    def fewest(grid: Grid) -> int:
        first = next(((i, j) for i, row in enumerate(grid) for j, label in enumerate(row) if label), None)
        if first is None:
            return 0
        return 1 + min(fewest(rest) for rest in without_a_rectangle(grid, *first))

    return fewest(tuple(map(tuple, labels.tolist())))


def without_a_rectangle(grid: Grid, i: int, j: int) -> Iterator[Grid]:
    """The grid less each rectangle of one label whose first corner is (i, j)."""
    cells = np.array(grid)
    for k in range(i + 1, len(cells) + 1):
        for m in range(j + 1, cells.shape[1] + 1):
            if (cells[i:k, j:m] == cells[i, j]).all():
                rest = cells.copy()
                rest[i:k, j:m] = 0
                yield tuple(map(tuple, rest.tolist()))


def counted(labels: np.ndarray) -> int:
    """By the theorem: concave corners, less the most chords that do not meet, plus pieces, less holes."""
    grid = np.pad(labels, 1)
    concave = {corner for corner in np.ndindex(grid.shape[0] - 1, grid.shape[1] - 1) if is_concave(grid, corner)}
    along_u = [chord for corner in concave if (chord := chord_from(grid.T, corner[::-1], turned=True))]
    along_v = [chord for corner in concave if (chord := chord_from(grid, corner))]
    on_v = {corner: number for number, chord in enumerate(along_v) for corner in chord}
    meetings = [(number, on_v[corner]) for number, chord in enumerate(along_u) for corner in chord if corner in on_v]
    lost = 0
    if meetings:
        a, b = np.array(meetings).T
        table = coo_array((np.ones(len(a)), (a, b)), shape=(len(along_u), len(along_v))).tocsr()
        lost = int((maximum_bipartite_matching(table, perm_type="column") >= 0).sum())
    return len(concave) - (len(along_u) + len(along_v) - lost) + euler(grid)


def is_concave(grid: np.ndarray, corner: Corner) -> bool:
    """Three of the four squares around a corner have one label."""
    around = grid[corner[0] : corner[0] + 2, corner[1] : corner[1] + 2].ravel().tolist()
    return any(label and around.count(label) == 3 for label in around)


def chord_from(grid: np.ndarray, corner: Corner, *, turned: bool = False) -> list[Corner]:
    """The corners along v from one concave corner to the next, through one label; nothing where there is none."""
    i, j = corner
    label, found = grid[i, j + 1], [corner]
    while label and (grid[i : i + 2, j + 1] == label).all():
        j += 1
        found.append((i, j))
        if is_concave(grid, (i, j)):
            return [(at[1], at[0]) for at in found] if turned else found
    return []


def euler(grid: np.ndarray) -> int:
    """Pieces less holes, of all labels: squares, less sides between equals, plus corners amid four equals."""
    there = grid != 0
    across, along = (grid[1:] == grid[:-1]) & there[1:], (grid[:, 1:] == grid[:, :-1]) & there[:, 1:]
    amid = across[:, 1:] & across[:, :-1] & along[1:] & along[:-1]
    return int(there.sum() - across.sum() - along.sum() + amid.sum())
