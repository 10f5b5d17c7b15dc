"""Kinds of fields: random, smooth, with obstacles, with lanes."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

Rng = np.random.Generator


def uniform(size: int, rng: Rng) -> np.ndarray:
    return rng.integers(1, 6, (size, size))


def normal(size: int, rng: Rng) -> np.ndarray:
    return np.clip(np.rint(rng.normal(2, 0.7, (size, size))), 0, 4).astype(int) + 1


def two_levels(size: int, rng: Rng) -> np.ndarray:
    return rng.integers(1, 3, (size, size))


def rough(size: int, rng: Rng) -> np.ndarray:
    return smoothed(size, rng, 2)


def smooth(size: int, rng: Rng) -> np.ndarray:
    return smoothed(size, rng, 6)


def smoothed(size: int, rng: Rng, sigma: int) -> np.ndarray:
    """Noise through a Gaussian, in five levels that come equally often."""
    reach = np.arange(-3 * sigma, 3 * sigma + 1)
    weights = np.exp(-(reach**2) / (2 * sigma**2))
    noise = rng.normal(size=(size, size))
    for axis in (0, 1):
        noise = np.apply_along_axis(lambda row: np.convolve(row, weights, "same")[:size], axis, noise)
    return np.asarray(np.searchsorted(np.quantile(noise, [0.2, 0.4, 0.6, 0.8]), noise) + 1)


def obstacles(size: int, rng: Rng) -> np.ndarray:
    """Rectangles on a floor."""
    levels = np.ones((size, size), dtype=int)
    for x, y, along, across, level in rng.integers((0, 0, 2, 2, 2), (size, size, 9, 9, 6), (size * size // 60, 5)):
        levels[x : x + along, y : y + across] = level
    return levels


def pyramid(size: int, rng: Rng) -> np.ndarray:
    rim = np.minimum(np.arange(size), np.arange(size)[::-1])
    return np.asarray(np.minimum(np.minimum.outer(rim, rim) * 10 // size, 4) + 1)


def lane(size: int, rng: Rng) -> np.ndarray:
    levels = rng.integers(1, 6, (size, size))
    levels[size // 3 : size // 3 + 6] = 3
    return levels


def dotted_plain(size: int, rng: Rng) -> np.ndarray:
    return np.where(rng.random((size, size)) < 0.25, rng.integers(1, 6, (size, size)), 3)


GRIDS: Mapping[str, Callable[[int, Rng], np.ndarray]] = {
    kind.__name__: kind for kind in (uniform, normal, two_levels, rough, smooth, obstacles, pyramid, lane, dotted_plain)
}
