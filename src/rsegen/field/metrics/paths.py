"""The cheapest paths over heights, to all cells at once, by fronts of growing cost."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rsegen.field.metrics.ground import Ground, Heights

UNREACHABLE = np.iinfo(np.int64).max
_WALL = 2**62


class CheapestPaths(NamedTuple):
    """Of the cheapest path from the first row to each cell: its cost, or UNREACHABLE, its moves, the cell before."""

    costs: Heights
    moves: NDArray[np.int64]
    predecessors: NDArray[np.int64]

    def path_to(self, place: int) -> NDArray[np.int64]:
        """The path to the cell of a flat index, as indices along both axes: (n, 2)."""
        cells = [place]
        while (place := int(self.predecessors.flat[place])) >= 0:
            cells.append(place)
        return np.stack(np.unravel_index(cells[::-1], self.predecessors.shape), axis=1)


def cheapest_paths(ground: Ground, tread: int, limits: tuple[int, int], *, shortest: bool) -> CheapestPaths:
    """The cheapest paths from the first row to each cell; a move costs tread + |dh| and stays within (climb, drop).

    shortest: of equally cheap paths, those with the fewest moves; else any, the same in every run. All lengths are in
    one unit. No move costs less than a tread, so all cells that cost less than the cheapest one of the front plus a
    tread are settled, and are expanded together.
    """
    flat, row = np.pad(ground.heights, 1, constant_values=_WALL).ravel(), ground.heights.shape[1] + 2
    rows, columns = (np.pad(open_, 1) for open_ in (ground.rows, ground.columns))
    costs, moves, predecessors = (np.full(flat.size, value) for value in (UNREACHABLE, 0, -1))
    front = np.arange(row + 1, 2 * row - 1)
    costs[front] = 0
    while len(front):
        settled = costs[front] < costs[front].min() + tread
        nodes, fronts = np.unique(front[settled]), [front[~settled]]
        may_go = {row: rows[nodes % row], 1: columns[nodes // row]}
        for side in (-row, -1, 1, row):
            rise = flat[nodes + side] - flat[nodes]
            cost = costs[nodes] + tread + np.abs(rise)
            better = cost < costs[nodes + side]
            if shortest:
                better |= (cost == costs[nodes + side]) & (moves[nodes] + 1 < moves[nodes + side])
            better &= may_go[abs(side)] & (rise <= limits[0]) & (-rise <= limits[1])
            reached = nodes[better] + side
            costs[reached], moves[reached], predecessors[reached] = (
                cost[better],
                moves[nodes[better]] + 1,
                nodes[better],
            )
            fronts.append(reached)
        front = np.concatenate(fronts)
    return CheapestPaths(_inner(costs, row), _inner(moves, row), _unpadded(_inner(predecessors, row), row))


def _inner(values: NDArray[np.int64], row: int) -> NDArray[np.int64]:
    return values.reshape(-1, row)[1:-1, 1:-1]


def _unpadded(places: NDArray[np.int64], row: int) -> NDArray[np.int64]:
    """Flat indices of the padded array as flat indices of the array without its border."""
    return np.where(places < 0, -1, (places // row - 1) * (row - 2) + places % row - 1)
