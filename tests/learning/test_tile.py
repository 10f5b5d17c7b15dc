"""The heights, the origin and the level squares of a tile are those of its boxes."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from rsegen import Pit, Random, Recipe
from rsegen.learning.tile import Tile, tile

RECIPE = Recipe(seed=3, unit_cm=5, boundary="none", obstacles=[Random(levels=6)])
SIZE = (1.6, 1.4)


@pytest.fixture(scope="module")
def rough() -> Tile:
    return tile(RECIPE, 1.0, 5, SIZE)


def _height(ground: Tile, x: float, y: float) -> float:
    """The top of the highest box at a place, edges counted."""
    tops = [
        centre[2] + size[2] / 2
        for centre, size, _ in ground.columns()
        if abs(x - centre[0]) <= size[0] / 2 + 1e-9 and abs(y - centre[1]) <= size[1] / 2 + 1e-9
    ]
    return max(tops)


@pytest.mark.parametrize("per_block", [1, 3])
def test_samples_reach_from_side_to_side_and_have_the_higher_block_at_edges(rough: Tile, per_block: int) -> None:
    samples = rough.samples(per_block)
    assert samples.shape == (16 * per_block + 1, 14 * per_block + 1)
    for i, j in product(range(0, samples.shape[0], 2), range(0, samples.shape[1], 3)):
        expected = _height(rough, i * 0.1 / per_block, j * 0.1 / per_block)
        assert samples[i, j] == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("radius", [0.0, 0.12, 0.5, 5.0])
def test_the_origin_is_as_high_as_the_highest_block_around_it(rough: Tile, radius: float) -> None:
    origin = rough.origin_above(radius)
    assert origin[:2] == pytest.approx(rough.origin[:2])
    offsets = np.clip(np.linspace(-radius, radius, 41), -0.69, 0.69)
    around = [_height(rough, origin[0] + dx, origin[1] + dy) for dx, dy in product(offsets[::4], offsets[::4])]
    assert max(around) <= origin[2] + 1e-9
    assert origin[2] <= rough.samples(1).max() + 1e-9


def test_level_squares_are_all_squares_on_level_ground(rough: Tile) -> None:
    squares = rough.level_squares(0.25, 0.05)
    heights = np.array([[_height(rough, i * 0.1 + 0.05, j * 0.1 + 0.05) for j in range(14)] for i in range(16)])
    windows = np.lib.stride_tricks.sliding_window_view(heights, (3, 3))
    level = np.ptp(windows, axis=(2, 3)) <= 0.05 + 1e-9
    assert 0 < len(squares) == level.sum() < level.size
    i, j = np.nonzero(level)
    expected = np.column_stack([i * 0.1 + 0.15, j * 0.1 + 0.15, windows[i, j].max(axis=(1, 2))])
    assert squares == pytest.approx(expected)
    assert len(rough.level_squares(3.0, 1.0)) == 0


def test_level_squares_are_not_in_holes() -> None:
    pit = replace(RECIPE, ground_level=4, obstacles=[Pit(levels=4, gap_width=3, first=(0, 0), last=(9, 9))])
    ground = tile(pit, 1.0, 5, SIZE)
    assert ground.samples(1).min() == pytest.approx(-0.15)
    assert 0 < len(ground.level_squares(0.1, 0.05)) < 16 * 14
    assert ground.level_squares(0.1, 0.05)[:, 2] == pytest.approx(0)
