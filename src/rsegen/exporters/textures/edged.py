"""Painted blocks: white, each a little lighter or darker, with dark edges."""

from __future__ import annotations

import numpy as np

from rsegen.exporters.textures.images import each
from rsegen.field.stepfield import Array, Mask
from rsegen.geometry import TILES

PIXELS = 32
"""Pixels along each side of a tile."""
PALETTE = np.repeat(np.rint(np.arange(64) * 255 / 63).astype(np.uint8)[:, None], 3, axis=1)
MEAN = 58
"""The row of the palette that most of the paint has."""

_EDGE = 0.35


def top(rng: np.random.Generator) -> Array:
    """The tones, 0 black to 1 white, of the tops of TILES x TILES blocks."""
    tones = _paint(rng, TILES * TILES).reshape(TILES, TILES)
    tones = tones.repeat(PIXELS, axis=0).repeat(PIXELS, axis=1)
    edge = _is_edge(TILES * PIXELS)
    return np.where(edge[:, None] | edge[None, :], _EDGE, tones)


def side(rng: np.random.Generator) -> Array:
    """The tones of the sides of TILES blocks, with an edge at their top."""
    tones = np.tile(_paint(rng, TILES).ravel().repeat(PIXELS), (TILES * PIXELS, 1))
    tones[:, _is_edge(TILES * PIXELS)] = _EDGE
    tones[0] = _EDGE
    return tones


def _paint(rng: np.random.Generator, count: int) -> Array:
    return each(rng, count, 0.86, 0.98)


def _is_edge(pixels: int) -> Mask:
    """Whether a pixel is the first or the last one of a tile."""
    return np.isin(np.arange(pixels) % PIXELS, (0, PIXELS - 1))
