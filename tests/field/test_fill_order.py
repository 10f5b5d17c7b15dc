"""The order of filling against every arrangement of blocks on small grids."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from rsegen.obstacles.rearranged import cells_with_neighbours, fill_order, rearranged
from rsegen.params.streams import Streams, generator
from rsegen.recipe.constraints.inventory import BlockCounts
from tests.support.arrangements import Counts, possible_counts

GRIDS = [(1, 1), (1, 6), (2, 2), (2, 5), (5, 2), (3, 3), (3, 4), (4, 3), (4, 4)]


def filled(shape: tuple[int, int], counts: Counts, corner: int = 0) -> np.ndarray:
    """Blocks in ascending order along the order of filling, from one of four corners."""
    like = np.add.outer(np.arange(shape[0]), np.arange(shape[1]))[:: 1 - corner % 2 * 2, :: 1 - corner // 2 * 2]
    levels = np.zeros(shape, dtype=np.int64)
    levels.flat[fill_order(np.ones(shape, dtype=bool), like.astype(float))] = np.repeat(np.arange(len(counts)), counts)
    return levels


def in_order(levels: np.ndarray, seed: int) -> np.ndarray | None:
    """The levels in an order with steps of 1 at most, if one is found."""
    (ordered,), (is_found,) = rearranged(levels[None], 1, Streams.of(seed, [0], "k"))
    return ordered if is_found else None


def highest_step(levels: np.ndarray) -> int:
    return max(int(np.abs(np.diff(levels, axis=axis)).max(initial=0)) for axis in (0, 1))


@pytest.mark.parametrize("limit", [1, 2])
@pytest.mark.parametrize("shape", GRIDS)
def test_the_ascending_order_keeps_to_any_limit_that_can_be_met(shape: tuple[int, int], limit: int) -> None:
    possible = possible_counts(shape, levels=4, limit=limit)
    assert possible
    for counts in possible:
        for corner in range(4):
            assert highest_step(filled(shape, counts, corner)) <= limit, (counts, corner)


@pytest.mark.parametrize("shape", [(2, 2), (3, 3), (3, 4), (4, 3)])
def test_an_order_is_found_exactly_if_one_exists(shape: tuple[int, int]) -> None:
    possible = possible_counts(shape, levels=3, limit=1)
    every = {counts for counts in np.ndindex(*[shape[0] * shape[1] + 1] * 3) if sum(counts) == shape[0] * shape[1]}
    assert 0 < len(possible) < len(every)
    for counts in every:
        levels = np.repeat(np.arange(3), counts).reshape(shape)
        found = in_order(levels, 1)
        assert (found is not None) == (counts in possible), counts
        if found is not None:
            assert tuple(np.bincount(found.ravel(), minlength=3)) == counts
            assert highest_step(found) <= 1


@pytest.mark.parametrize("counts", [(36, 9, 55), (36, 9, 10, 45), (1, 2, 97)])
def test_the_tightest_counts_of_a_pallet_have_an_order(counts: Counts) -> None:
    levels = np.repeat(np.arange(len(counts)), counts).reshape(10, 10)
    for seed in (1, 2, 3):
        found = in_order(levels, seed)
        assert found is not None
        assert highest_step(found) == 1
        assert tuple(np.bincount(found.ravel())) == counts
    fewer = (counts[0] + 1, counts[1] - 1, *counts[2:])
    assert in_order(np.repeat(np.arange(len(fewer)), fewer).reshape(10, 10), 1) is None


@pytest.mark.parametrize("pallets", [1, 2])
@pytest.mark.parametrize(("shape", "limit"), [((2, 3), 1), ((3, 3), 1), ((3, 3), 2)])
def test_the_most_blocks_of_a_stock_are_used(shape: tuple[int, int], limit: int, pallets: int) -> None:
    one = possible_counts(shape, levels=4, limit=limit)
    possible = np.array(list(one if pallets == 1 else {tuple(np.add(a, b)) for a in one for b in one}))
    there = np.ones((shape[0] * pallets + pallets - 1, shape[1]), dtype=bool)
    there[shape[0] :: shape[0] + 1] = False
    cells = int(there.sum())
    n = cells_with_neighbours(fill_order(there, np.zeros(there.shape)), there)
    rng, emptied = generator(5, 0, "k"), 0
    for _ in range(60):
        owned = np.array([cells, *(rng.random(3) * cells * 0.7).astype(int)])
        within = possible[(possible[:, 1:] <= owned[1:]).all(axis=1)]
        most = int((cells - within[:, 0]).max())
        wished = np.floor(np.diff([0, *np.sort(rng.random(3)), 1]) * cells).astype(int)
        wished[0] += cells - wished.sum()
        for blocks in (cells, most // 2):
            counts = BlockCounts(owned, limit, n).nearest(wished, blocks, np.zeros(4, dtype=int))
            assert (possible == counts).all(axis=1).any()
            assert (counts[1:] <= owned[1:]).all()
            assert cells - counts[0] >= min(most, blocks)
        emptied += most < min(cells, owned[1:].sum())
    assert emptied  # by the limit, not by the stock


def test_cells_with_neighbours_are_counted() -> None:
    there = np.ones((3, 3), dtype=bool)
    order = fill_order(there, np.add.outer(np.arange(3), np.arange(3)).astype(float))
    assert order[0] == 0
    assert order[-1] == 8
    assert cells_with_neighbours(order, there).tolist() == [0, 3, 5, 6, 7, 8, 8, 9, 9, 9]


def test_frames_part_the_order() -> None:
    there = np.ones((5, 5), dtype=bool)
    there[2] = there[:, 2] = False
    order = fill_order(there, np.where(np.arange(5)[:, None] < 2, 5.0, 1.0) * np.ones((5, 5)))
    assert sorted(order) == np.flatnonzero(there).tolist()
    assert all(cell // 5 > 2 for cell in order[:8])  # the lower rectangles are first
    for part, other in combinations(range(4), 2):
        assert not set(order[part * 4 : part * 4 + 4]) & set(order[other * 4 : other * 4 + 4])
