"""Connected and strongly connected components of graphs, in numpy.

Connected: hooking and pointer jumping (Shiloach and Vishkin 1982): every root hooks onto the smallest adjacent root,
then every node points to its root; the number of rounds grows with the logarithm of the size, each linear in the edges.

Strongly connected: edges in both directions connect nodes at once, which on a field leaves few nodes; edges on no cycle
are peeled off; Tarjan's algorithm (1972), without recursion, has the rest. It is a Python loop, so a graph whose edges
are mostly one-way (a robot that drops far more than it climbs, on a rough map) is slow.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from rsegen.field.stepfield import Ints, Mask
from rsegen.params.arrays import arange, least_at, where


def neighbours(shape: tuple[int, ...]) -> tuple[Ints, Ints]:
    """Return every pair of grid cells that share a side, as flat indices: the one of smaller x or y, and the other."""
    cell = np.arange(shape[0] * shape[1]).reshape(shape)
    pairs = [(cell[:-1], cell[1:]), (cell[:, :-1], cell[:, 1:])]
    low, high = (np.concatenate([pair[end].ravel() for pair in pairs]) for end in (0, 1))
    return low, high


def component_labels(nodes: int, a: Ints, b: Ints) -> Ints:
    """Return for each node the smallest node of its connected component, for undirected edges a - b.

    Every root is attached to the smallest adjacent root and pointers are shortened, until no edge joins two roots.
    """
    root: Ints = arange(nodes, a)
    while True:
        a, b = root[a], root[b]
        apart = a != b
        if not apart.any():
            return root
        a, b = a[apart], b[apart]
        smaller = a < b
        least_at(root, where(smaller, b, a), where(smaller, a, b))
        while (root != (above := root[root])).any():
            root = above


def strongly_connected(nodes: int, a: Ints, b: Ints, onward: Mask, back: Mask) -> Ints:
    """Return for each node the index of its strongly connected component.

    Edges lead from a to b if `onward`, from b to a if `back`. Edges in both directions connect nodes at once; between
    the components that they form, one-way edges may close cycles.
    """
    both, either = onward & back, onward != back
    labels, place = np.unique(component_labels(nodes, a[both], b[both]), return_inverse=True)
    tails, heads = (place[np.where(onward, first, second)[either]] for first, second in ((a, b), (b, a)))
    tails, heads = _on_cycles(len(labels), tails, heads)
    used, ends = np.unique(np.concatenate([tails, heads]), return_inverse=True)
    group = np.arange(len(labels))
    group[used] = used[_strong(len(used), ends[: len(tails)], ends[len(tails) :])]
    return np.asarray(group[place])


def _on_cycles(nodes: int, tails: Ints, heads: Ints) -> tuple[Ints, Ints]:
    """Return the edges without most of those on no cycle: nothing leads to their tail, or on from their head."""
    inside = tails != heads
    while not inside.all():
        tails, heads = tails[inside], heads[inside]
        entered, left = (np.bincount(part, minlength=nodes) > 0 for part in (heads, tails))
        inside = entered[tails] & left[heads]
    return tails, heads


def _strong(nodes: int, tails: Ints, heads: Ints) -> list[int]:
    """Return for each node one node of its strongly connected component, by Tarjan's algorithm without recursion."""
    # For each node an iterator over the nodes that its edges lead to.
    by_tail = np.argsort(tails, kind="stable")
    starts, ahead = np.searchsorted(tails[by_tail], np.arange(nodes + 1)).tolist(), heads[by_tail].tolist()
    onward = [iter(ahead[start:stop]) for start, stop in pairwise(starts)]
    # `order` is the order of discovery from 1, `low` the earliest open node that is reachable; a node whose `low` is
    # its own order is the first of its component, and all open nodes after it belong to it.
    order, low, group = [0] * nodes, [0] * nodes, [0] * nodes
    seen, open_, way = 0, list[int](), list[int]()
    for root in range(nodes):
        way += [] if order[root] else [root]
        while way:
            node = way[-1]
            if not order[node]:
                order[node] = low[node] = seen = seen + 1
                open_.append(node)
            for head in onward[node]:
                if not order[head]:
                    way.append(head)
                    break
                low[node] = min(low[node], low[head])
            else:
                way.pop()
                if low[node] == order[node]:
                    _pop_component(node, open_, group, low)
                elif way:
                    low[way[-1]] = min(low[way[-1]], low[node])
    return group


def _pop_component(node: int, open_: list[int], group: list[int], low: list[int]) -> None:
    """Remove a complete component from the stack and number its nodes, so that no other node's low link uses it."""
    while True:
        last = open_.pop()
        group[last], low[last] = node, len(group) + 1
        if last == node:
            return
