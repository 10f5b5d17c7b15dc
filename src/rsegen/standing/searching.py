"""The cheapest way through a graph that is given place by place (A*, Hart, Nilsson and Raphael 1968).

Of all places at the front the one goes on whose cost, and a bound of what is left, are least. Cost: of each place once,
and of each move out of it, in Python: some microseconds.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from heapq import heapify, heappop, heappush

import numpy as np

_BEYOND = -1
"""The place behind all goals, to which each leads."""


def cheapest(
    starts: Mapping[int, tuple[float, float]],
    goals: Mapping[int, tuple[float, float]],
    onward: Callable[[int], Iterable[tuple[int, float, float]]],
    cost_of: Callable[[float, float, float], float],
    left: Sequence[float],
    first: float = 0.0,
) -> tuple[float, list[int]] | None:
    """Return the least cost from a start to a goal, and the places between; None if no goal is reached.

    starts, goals: the length of what leads there, and on from there, and the worst on it; places are numbers from 0 on
    onward: places to which a place leads, the length of each move, and the worst on it
    cost_of: the cost after a move, from that before, the length and the worst of it; it never falls
    left: of each place a cost that no way to a goal is below, and which falls by no more than a move costs
    first: the cost before a start
    """
    costs, before = {at: cost_of(first, *lane) for at, lane in starts.items()}, dict[int, int]()
    # Of equal ones the nearest goes on.
    front = [(cost + left[at], 0.0, at) for at, cost in costs.items() if cost < np.inf]
    heapify(front)
    done, arrived = set[int](), np.inf
    while front:
        _, run, at = heappop(front)
        if at == _BEYOND:
            return arrived, _traced(before)
        if at in done:
            continue
        done.add(at)
        if at in goals and (last := cost_of(costs[at], *goals[at])) < arrived:
            arrived, before[_BEYOND] = last, at
            heappush(front, (last, run, _BEYOND))
        for on, length, worst in onward(at):
            after = cost_of(costs[at], length, worst)
            if after < costs.get(on, np.inf) - 1e-9:
                costs[on], before[on] = after, at
                heappush(front, (after + left[on], run + length, on))
    return None


def _traced(before: Mapping[int, int]) -> list[int]:
    """Return the places from a start to a goal, by the place before each."""
    way = [before[_BEYOND]]
    while way[-1] in before:
        way.append(before[way[-1]])
    return way[::-1]
