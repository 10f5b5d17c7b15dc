"""The formulas of the method, written out cell by cell, against what the obstacles give."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from statistics import NormalDist

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rsegen import (
    DiagonalBarrier,
    HorizontalBarrier,
    NormalRandom,
    Obstacle,
    Peak,
    Platform,
    Random,
    Recipe,
    build,
)
from rsegen.errors import ParameterError
from rsegen.field.stepfield import Levels
from rsegen.params.sorts import Cell

L = 10
CELLS = st.integers(0, L - 1)
HEIGHTS = st.integers(2, 12)
SOFTNESS = st.one_of(st.sampled_from([0, 50, 100]), st.floats(0, 100))


def field_of(obstacle: Obstacle, first: Cell, last: Cell, chunks: int = 1) -> Levels:
    placed = replace(obstacle, first=first, last=last)
    return build(Recipe(chunk_size=L, chunks=(chunks, chunks), boundary="none", seed=1, obstacles=(placed,))).levels


def shaped_levels(levels: int, profile: Callable[[int, int], float]) -> np.ndarray:
    level = [[math.floor((levels - 1) * profile(x, y) + 1e-9) for y in range(L)] for x in range(L)]
    return np.array(level)


def barrier_profile(softness: float, first: Cell, last: Cell) -> Callable[[int, int], float]:
    w = softness / 100 * L
    (x1, y1), (x2, y2) = first, last

    def f(x: int, y: int) -> float:
        squared = (x2 - x1) ** 2 + (y2 - y1) ** 2
        t = ((x - x1) * (x2 - x1) + (y - y1) * (y2 - y1)) / squared if squared else 0.0
        t = min(1.0, max(0.0, t))
        dx, dy = x - x1 - t * (x2 - x1), y - y1 - t * (y2 - y1)
        d = math.sqrt(dx * dx + dy * dy)
        if d <= 0.5:
            return 1.0
        return max(0.0, 1 - (d - 0.5) / w) if w else 0.0

    return f


@given(HEIGHTS, SOFTNESS, st.tuples(CELLS, CELLS), CELLS, st.booleans())
def test_horizontal_barrier_follows_its_formula(
    levels: int, softness: float, first: Cell, end: int, along_x: bool
) -> None:
    last = (end, first[1]) if along_x else (first[0], end)
    found = field_of(HorizontalBarrier(levels=levels, softness=softness), first, last)
    np.testing.assert_array_equal(found, shaped_levels(levels, barrier_profile(softness, first, last)))


@given(HEIGHTS, SOFTNESS, st.tuples(CELLS, CELLS), st.tuples(CELLS, CELLS))
def test_diagonal_barrier_follows_its_formula(levels: int, softness: float, first: Cell, last: Cell) -> None:
    found = field_of(DiagonalBarrier(levels=levels, softness=softness), first, last)
    np.testing.assert_array_equal(found, shaped_levels(levels, barrier_profile(softness, first, last)))


def test_corner_to_corner_diagonal_without_softness_is_the_diagonal() -> None:
    found = field_of(DiagonalBarrier(levels=5, softness=0), (0, 0), (9, 9))
    np.testing.assert_array_equal(found, 4 * np.eye(10))


def peak_profile(softness: float, first: Cell, last: Cell) -> Callable[[int, int], float]:
    half = [(abs(a - b) + 1) / 2 for a, b in zip(first, last, strict=True)]
    radius = min(half)
    centre = [(a + b) / 2 for a, b in zip(first, last, strict=True)]

    def distance(x: int, y: int) -> float:
        scaled = [(at - c) * (radius / h) for at, c, h in zip((x, y), centre, half, strict=True)]
        return math.sqrt(scaled[0] ** 2 + scaled[1] ** 2)

    least = min(distance(x, y) for x in range(L) for y in range(L))
    w = softness / 100 * (radius - least)

    def f(x: int, y: int) -> float:
        d = distance(x, y)
        if not w:
            return 1.0 if d < radius else 0.0
        return min(1.0, max(0.0, (radius - d) / w))

    return f


@given(HEIGHTS, SOFTNESS, st.tuples(CELLS, CELLS), st.tuples(CELLS, CELLS))
def test_peak_follows_its_formula(levels: int, softness: float, first: Cell, last: Cell) -> None:
    found = field_of(Peak(levels=levels, softness=softness), first, last)
    np.testing.assert_array_equal(found, shaped_levels(levels, peak_profile(softness, first, last)))


@given(HEIGHTS, SOFTNESS, CELLS, st.integers(1, L))
def test_peak_always_reaches_its_levels(levels: int, softness: float, corner: int, side: int) -> None:
    first = min(corner, L - side)
    found = field_of(Peak(levels=levels, softness=softness), (first, 0), (first + side - 1, side - 1))
    assert found.max() == levels - 1


@pytest.mark.parametrize(("side", "least"), [(1, 0), (5, 0), (2, math.sqrt(0.5)), (6, math.sqrt(0.5))])
def test_least_distance_of_a_square_peak_is_as_the_method_says(side: int, least: float) -> None:
    centre = (side - 1) / 2
    assert min(math.dist((x, y), (centre, centre)) for x in range(side) for y in range(side)) == pytest.approx(least)


def uniform_of(obstacle: Obstacle, seed: int, shape: tuple[int, int]) -> np.ndarray:
    """The numbers that a random obstacle over the whole map is made of."""
    from rsegen.params.streams import generator

    recipe = Recipe(seed=seed, obstacles=(obstacle,))
    return generator(seed, 0, recipe.obstacles[0].key or "").random(shape)


@given(HEIGHTS, SOFTNESS, st.integers(0, 1000))
def test_random_is_floor_of_n_f(levels: int, softness: float, seed: int) -> None:
    obstacle = Random(levels=levels, softness=softness)
    found = build(Recipe(boundary="none", seed=seed, obstacles=(obstacle,))).levels
    u = uniform_of(obstacle, seed, found.shape)
    expected = [[math.floor(levels * (each * (1 - softness / 100))) for each in row] for row in u.tolist()]
    np.testing.assert_array_equal(found, expected)


@given(HEIGHTS, SOFTNESS, st.floats(0.01, 2), st.integers(0, 1000))
def test_normal_random_is_floor_of_n_f(levels: int, softness: float, spread: float, seed: int) -> None:
    obstacle = NormalRandom(levels=levels, softness=softness, spread=spread)
    found = build(Recipe(boundary="none", seed=seed, obstacles=(obstacle,))).levels
    u = uniform_of(obstacle, seed, found.shape)

    def level(each: float) -> int:
        f = min(max(0.5 + NormalDist().inv_cdf(each) * spread, 0.0), 1 - 1e-12) * (1 - softness / 100)
        return math.floor(levels * f)

    np.testing.assert_array_equal(found, [[level(each) for each in row] for row in u.tolist()])


def share_of_levels(obstacle: Obstacle) -> np.ndarray:
    recipe = Recipe(chunk_size=300, boundary="none", seed=3, obstacles=(obstacle,))
    return np.bincount(build(recipe).levels.ravel(), minlength=obstacle.levels) / 300**2


def test_every_level_of_random_is_equally_likely() -> None:
    np.testing.assert_allclose(share_of_levels(Random(levels=5)), 1 / 5, atol=0.01)


def test_weights_are_the_shares_of_the_levels() -> None:
    shares = share_of_levels(Random(levels=5, weights=(1, 0, 4, 2, 3)))
    np.testing.assert_allclose(shares, [0.1, 0, 0.4, 0.2, 0.3], atol=0.01)
    assert shares[1] == 0


@given(HEIGHTS, SOFTNESS, st.integers(0, 1000))
def test_equal_weights_give_the_levels_of_no_weights(levels: int, softness: float, seed: int) -> None:
    plain, weighted = (
        build(Recipe(boundary="none", seed=seed, obstacles=(replace(obstacle, key="k"),))).levels
        for obstacle in (
            Random(levels=levels, softness=softness),
            Random(levels=levels, softness=softness, weights=(3,) * levels),
        )
    )
    np.testing.assert_array_equal(plain, weighted)


def test_normal_random_is_smoother_than_random() -> None:
    def mean_step(obstacle: Obstacle) -> float:
        recipe = Recipe(chunk_size=100, boundary="none", seed=3, obstacles=(obstacle,))
        return float(np.abs(np.diff(build(recipe).levels, axis=0)).mean())

    assert mean_step(NormalRandom(levels=5)) < mean_step(Random(levels=5))


@given(HEIGHTS, SOFTNESS, st.tuples(CELLS, CELLS), st.tuples(CELLS, CELLS), st.integers(0, 11))
def test_platform_follows_its_formula(levels: int, softness: float, first: Cell, last: Cell, level: int) -> None:
    top = min(level, levels - 1)
    (x1, x2), (y1, y2) = sorted((first[0], last[0])), sorted((first[1], last[1]))
    w = softness / 100 * L

    def f(x: int, y: int) -> float:
        d = math.hypot(max(x1 - x, 0, x - x2), max(y1 - y, 0, y - y2))
        if d <= 0.5:
            return top / (levels - 1)
        return max(0.0, 1 - (d - 0.5) / w) * (top / (levels - 1)) if w else 0.0

    found = field_of(Platform(levels=levels, softness=softness, level=top), first, last)
    np.testing.assert_array_equal(found, shaped_levels(levels, f))


@given(st.integers(0, 4), st.integers(0, 1000))
def test_a_platform_is_even_on_top_of_whatever_was_there(level: int, seed: int) -> None:
    rough, even = Random(levels=5), Platform(levels=5, level=level, size=(3, 4))
    rows = (rough, replace(even, first=(2, 5)))
    found = build(Recipe(chunk_size=L, boundary="none", seed=seed, obstacles=rows)).levels
    below = build(Recipe(chunk_size=L, boundary="none", seed=seed, obstacles=rows[:1])).levels
    assert set(found[2:5, 5:9].ravel().tolist()) == {level}
    found_outside, below_outside = found.copy(), below.copy()
    found_outside[2:5, 5:9] = below_outside[2:5, 5:9] = 0
    np.testing.assert_array_equal(found_outside, below_outside)


def test_a_platform_above_its_levels_is_refused() -> None:
    with pytest.raises(ParameterError, match="level: 5 is more than the highest level, 4"):
        Platform(levels=5, level=5)
