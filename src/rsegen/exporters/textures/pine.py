"""Blocks of pine: end grain on their tops, long grain on their sides, every block a little different.

Early wood is light and becomes darker through a year; the next ring begins with a sharp edge.
"""

from __future__ import annotations

import numpy as np

from rsegen.exporters.textures.images import each, noise
from rsegen.field.stepfield import Array
from rsegen.geometry import TILES

PIXELS = 64
"""Pixels along each side of a tile."""

_STOPS = ((0, 58, 38, 24), (16, 140, 88, 46), (32, 196, 142, 86), (48, 226, 184, 126), (63, 244, 216, 168))
PALETTE = np.stack(
    [np.rint(np.interp(np.arange(64), *np.array(_STOPS).T[[0, channel]])) for channel in (1, 2, 3)], axis=1
).astype(np.uint8)
"""From the dark of a gap to the light of early wood."""
MEAN = 41
"""The row of the palette that most of the wood has."""


def top(rng: np.random.Generator) -> Array:
    """End grain: the tones, 0 dark to 1 light, of TILES x TILES blocks, each with a pith of its own."""
    count, shape = TILES * TILES, (TILES * TILES, PIXELS, PIXELS)
    x, y = _middles(PIXELS)[None, None, :], _middles(PIXELS)[None, :, None]
    across, along = x - each(rng, count, -0.3, 1.3), y - each(rng, count, -0.3, 1.3)
    radius = np.sqrt(across * across * each(rng, count, 0.8, 1.2) + along * along)
    radius += 0.035 * noise(rng, shape, (3, 3)) + 0.008 * noise(rng, shape, (12, 12))
    rings = _rings(radius / each(rng, count, 0.055, 0.105) + 0.8 * noise(rng, shape, (2, 2)))
    tones = each(rng, count, 0.54, 0.70) + 0.26 * (rings - 0.5)
    tones += 0.05 * noise(rng, shape, (2, 2)) + 0.05 * noise(rng, shape, (32, 32))
    tones -= 0.3 * _crack(rng, across, along)
    rim = np.minimum(np.minimum(x, 1 - x), np.minimum(y, 1 - y)) * PIXELS
    tones = np.where(rim < 1, 0, np.where(rim < 2, 0.72 * tones, tones))
    return np.asarray(_grid(tones, TILES))


def side(rng: np.random.Generator) -> Array:
    """Long grain: the tones of TILES posts side by side, with a few knots, and an edge at their top."""
    rows = TILES * PIXELS
    shape = (TILES, rows, PIXELS)
    x, y = _middles(PIXELS)[None, None, :], _middles(PIXELS, rows)[None, :, None]
    distance = np.abs(x - each(rng, TILES, -0.2, 1.2)) + 0.05 * noise(rng, shape, (4, 1))
    distance += 0.01 * noise(rng, shape, (16, 4))
    bent, dark = _knots(rng, x, y)
    distance += bent
    rings = _rings((2.2 * distance * distance + 0.6 * distance) / each(rng, TILES, 0.05, 0.11))
    tones = each(rng, TILES, 0.62, 0.78) + 0.22 * (rings - 0.5) - dark
    tones += 0.04 * noise(rng, shape, (3, 2)) + 0.05 * noise(rng, shape, (24, 40))
    rim = np.minimum(x, 1 - x) * PIXELS
    tones = np.where(rim < 1, 0.02, np.where(rim < 2, 0.78 * tones, tones))
    depth = y * PIXELS
    tones = np.where(depth < 1, 0.05, np.where(depth < 3, np.minimum(tones + 0.1, 1), tones))
    return np.asarray(tones.transpose(1, 0, 2).reshape(rows, rows))


def _rings(years: Array) -> Array:
    """The tone of wood that grew at a time in years: 1 in spring, down to 0 in autumn."""
    time = years - np.floor(years)
    return np.asarray(1 - time * time * time)


def _crack(rng: np.random.Generator, across: Array, along: Array) -> Array:
    """Where a block has a crack, which starts at the pith: in half of them."""
    count = len(across)
    x, y = each(rng, count, -1, 1), each(rng, count, -1, 1)
    length = np.sqrt(x * x + y * y) + 0.001
    aside = np.abs(across * y - along * x) / length + 0.01 * noise(rng, np.broadcast(across, along).shape, (6, 6))
    outward = (across * x + along * y) / length
    inside = (outward > 0) & (outward < each(rng, count, 0.3, 0.7))
    return np.asarray((aside < 0.012) & inside & (each(rng, count, 0, 1) < 0.5))


def _knots(rng: np.random.Generator, x: Array, y: Array) -> tuple[Array, Array]:
    """How far knots push the rings aside, and how much darker they are: two per post."""
    bent = dark = np.zeros(1)
    for _ in range(2):
        size = each(rng, TILES, 0.05, 0.11)
        aside, above = x - each(rng, TILES, 0, 1), 0.45 * (y - each(rng, TILES, 0, TILES))
        distance = np.sqrt(aside * aside + above * above)
        bent = bent + np.where(aside > 0, 1.2, -1.2) * size / (1 + distance * distance / (size * size))
        dark = dark + 0.38 * np.maximum(0, 1 - 1.1 * distance / size) * (0.7 + 0.3 * _rings(distance / 0.02))
    return bent, dark


def _middles(pixels: int, count: int | None = None) -> Array:
    """The middles of `count` pixels (default: `pixels`), `pixels` of which are 1."""
    return np.asarray((np.arange(count or pixels) + 0.5) / pixels)


def _grid(tiles: Array, columns: int) -> Array:
    """Tiles (n, side, side) as one image, row by row."""
    side = tiles.shape[1]
    return tiles.reshape(-1, columns, side, side).transpose(0, 2, 1, 3).reshape(-1, columns * side)
