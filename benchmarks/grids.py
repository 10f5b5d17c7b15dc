"""Grids of levels 1..5 to measure on, shape (n, n), each the same for the same seed. numpy alone."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray

Levels = NDArray[np.int16]

BLOCK = 0.1
"""Block width and unit, metres."""

TOP = 5


def uniform(size: int, seed: int = 1, *, top: int = TOP) -> Levels:
    """Every level as likely as any other."""
    return np.random.default_rng(seed).integers(1, top + 1, (size, size), dtype=np.int16)


def normal(size: int, seed: int = 1) -> Levels:
    """Levels around 2, with a standard deviation of 0.7."""
    drawn = np.random.default_rng(seed).normal(2, 0.7, (size, size))
    return np.rint(drawn).clip(1, TOP).astype(np.int16)


def smooth(size: int, seed: int = 1, *, sigma: float) -> Levels:
    """White noise under a Gaussian of `sigma` cells, cut into levels that are equally frequent."""
    noise = np.random.default_rng(seed).normal(size=(size, size))
    for _ in range(2):
        noise = np.array([_blurred(row, sigma) for row in noise]).T
    cuts = np.quantile(noise, np.arange(1, TOP) / TOP)
    return (1 + np.searchsorted(cuts, noise)).astype(np.int16)


def rectangles(size: int, seed: int = 1) -> Levels:
    """A floor of level 1 with one rectangle, 2 to 8 cells a side and up to level 5, for each 100 cells."""
    rng = np.random.default_rng(seed)
    levels = np.ones((size, size), dtype=np.int16)
    for _ in range(max(1, size * size // 100)):
        width, depth = rng.integers(2, 9, 2)
        x, y = rng.integers(0, max(size - width, 1)), rng.integers(0, max(size - depth, 1))
        levels[x : x + width, y : y + depth] = rng.integers(2, TOP + 1)
    return levels


def pyramid(size: int, seed: int = 1) -> Levels:
    """A hill of five square steps; there is no chance in it."""
    from_edge = np.minimum(np.arange(size), np.arange(size)[::-1])
    inward = np.minimum(from_edge[:, None], from_edge[None, :])
    return (1 + inward * 2 * TOP // size).clip(1, TOP).astype(np.int16)


GRIDS: dict[str, Callable[[int, int], Levels]] = {
    "uniform, 5 levels": uniform,
    "normal round level 2, sd 0.7": normal,
    "uniform, 2 levels": partial(uniform, top=2),
    "noise smoothed sigma 2 cells, 5 levels": partial(smooth, sigma=2),
    "noise smoothed sigma 6 cells, 5 levels": partial(smooth, sigma=6),
    "discrete rectangles on a floor": rectangles,
    "5-step pyramid hill": pyramid,
}


def _blurred(row: NDArray[np.float64], sigma: float) -> NDArray[np.float64]:
    reach = int(4 * sigma)
    weights = np.exp(-((np.arange(-reach, reach + 1) / sigma) ** 2) / 2)
    padded = np.pad(row, reach, mode="symmetric")
    return np.convolve(padded, weights / weights.sum(), mode="valid")
