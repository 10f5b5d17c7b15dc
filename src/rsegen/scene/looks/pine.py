"""Blocks of pine: end grain on their tops, long grain on their sides, every block a little different.

Wood grows in rings: the tone is a function of the time in years at which it grew, 1 in spring and 1 - t^3 until autumn,
and the next ring begins with a sharp edge. On a top the time is the distance from a pith in or next to the block, over
the width of a ring; on a side it is the distance from the plane through the pith, in which rings are farther apart.
Both are distorted by smooth noise; cracks run outward from the pith, and knots push the rings aside.

The numbers in `top`, `side`, `_crack` and `_knots` are a matter of looks: nothing but the pictures depends on them.
Lengths are shares of a block's width: rings of 0.055 to 0.105 are 5 to 10 mm in a block of 10 cm, wider than real ones,
of which one would see nothing at 64 pixels.
"""

from __future__ import annotations

import numpy as np

from rsegen.field.stepfield import Array
from rsegen.geometry import TILES
from rsegen.scene.looks.images import noise, one_per_image

PIXELS = 64
"""Pixels along each side of a tile: a ring then has four or more."""

_STOPS = ((0, 58, 38, 24), (16, 140, 88, 46), (32, 196, 142, 86), (48, 226, 184, 126), (63, 244, 216, 168))
PALETTE = np.stack(
    [np.rint(np.interp(np.arange(64), *np.array(_STOPS).T[[0, channel]])) for channel in (1, 2, 3)], axis=1
).astype(np.uint8)
"""Colours from the dark of a gap to the light of early wood, between stops (index, red, green, blue)."""

MEAN = 41
"""Row of the palette that most of the wood has."""


def top(rng: np.random.Generator) -> Array:
    """Return end grain: the tones, 0 dark to 1 light, of TILES x TILES blocks, each with its own pith."""
    count, shape = TILES * TILES, (TILES * TILES, PIXELS, PIXELS)
    x, y = _middles(PIXELS)[None, None, :], _middles(PIXELS)[None, :, None]
    across, along = x - one_per_image(rng, count, -0.3, 1.3), y - one_per_image(rng, count, -0.3, 1.3)
    radius = np.sqrt(across * across * one_per_image(rng, count, 0.8, 1.2) + along * along)
    radius += 0.035 * noise(rng, shape, (3, 3)) + 0.008 * noise(rng, shape, (12, 12))
    rings = _rings(radius / one_per_image(rng, count, 0.055, 0.105) + 0.8 * noise(rng, shape, (2, 2)))
    tones = one_per_image(rng, count, 0.54, 0.70) + 0.26 * (rings - 0.5)
    tones += 0.05 * noise(rng, shape, (2, 2)) + 0.05 * noise(rng, shape, (32, 32))
    tones -= 0.3 * _crack(rng, across, along)
    # The rim of a block is a gap of one pixel and a worn edge of another.
    rim = np.minimum(np.minimum(x, 1 - x), np.minimum(y, 1 - y)) * PIXELS
    tones = np.where(rim < 1, 0, np.where(rim < 2, 0.72 * tones, tones))
    # The tiles as one image, row by row.
    rows = tones.reshape(TILES, TILES, PIXELS, PIXELS).transpose(0, 2, 1, 3)
    return np.asarray(rows.reshape(TILES * PIXELS, TILES * PIXELS))


def side(rng: np.random.Generator) -> Array:
    """Return long grain: the tones of TILES posts side by side, with a few knots, and an edge at their top."""
    rows = TILES * PIXELS
    shape = (TILES, rows, PIXELS)
    x, y = _middles(PIXELS)[None, None, :], _middles(rows)[None, :, None]
    distance = np.abs(x - one_per_image(rng, TILES, -0.2, 1.2)) + 0.05 * noise(rng, shape, (4, 1))
    distance += 0.01 * noise(rng, shape, (16, 4))
    bent, dark = _knots(rng, x, y)
    distance += bent
    rings = _rings((2.2 * distance * distance + 0.6 * distance) / one_per_image(rng, TILES, 0.05, 0.11))
    tones = one_per_image(rng, TILES, 0.62, 0.78) + 0.22 * (rings - 0.5) - dark
    tones += 0.04 * noise(rng, shape, (3, 2)) + 0.05 * noise(rng, shape, (24, 40))
    rim = np.minimum(x, 1 - x) * PIXELS
    tones = np.where(rim < 1, 0.02, np.where(rim < 2, 0.78 * tones, tones))
    depth = y * PIXELS
    tones = np.where(depth < 1, 0.05, np.where(depth < 3, np.minimum(tones + 0.1, 1), tones))
    return np.asarray(tones.transpose(1, 0, 2).reshape(rows, rows))


def _rings(years: Array) -> Array:
    """Return the tone of wood that grew at a time in years: 1 in spring, down to 0 in autumn."""
    time = years - np.floor(years)
    return np.asarray(1 - time * time * time)


def _crack(rng: np.random.Generator, across: Array, along: Array) -> Array:
    """Return the pixels of cracks, which start at the pith, in half of the blocks."""
    count = len(across)
    x, y = one_per_image(rng, count, -1, 1), one_per_image(rng, count, -1, 1)
    length = np.sqrt(x * x + y * y) + 0.001
    aside = np.abs(across * y - along * x) / length + 0.01 * noise(rng, np.broadcast(across, along).shape, (6, 6))
    outward = (across * x + along * y) / length
    inside = (outward > 0) & (outward < one_per_image(rng, count, 0.3, 0.7))
    return np.asarray((aside < 0.012) & inside & (one_per_image(rng, count, 0, 1) < 0.5))


def _knots(rng: np.random.Generator, x: Array, y: Array) -> tuple[Array, Array]:
    """Return the distance by which knots push the rings aside, and their darkness; two knots per post."""
    bent = dark = np.zeros(1)
    for _ in range(2):
        size = one_per_image(rng, TILES, 0.05, 0.11)
        aside, above = x - one_per_image(rng, TILES, 0, 1), 0.45 * (y - one_per_image(rng, TILES, 0, TILES))
        distance = np.sqrt(aside * aside + above * above)
        bent = bent + np.where(aside > 0, 1.2, -1.2) * size / (1 + distance * distance / (size * size))
        dark = dark + 0.38 * np.maximum(0, 1 - 1.1 * distance / size) * (0.7 + 0.3 * _rings(distance / 0.02))
    return bent, dark


def _middles(count: int) -> Array:
    """Return the centres of `count` pixels, of which PIXELS have a length of 1."""
    return np.asarray((np.arange(count) + 0.5) / PIXELS)
