"""Painted blocks: white, each a little lighter or darker, with dark edges.

The edges show where one block ends and the next begins on merged faces, whose triangles say nothing about blocks.
"""

from __future__ import annotations

import numpy as np

from rsegen.field.stepfield import Array
from rsegen.geometry import TILES
from rsegen.scene.looks.images import one_per_image

PIXELS = 32
"""Pixels along each side of a tile: an edge is one of them, 3 mm of a block of 10 cm."""
PALETTE = np.repeat(np.rint(np.arange(64) * 255 / 63).astype(np.uint8)[:, None], 3, axis=1)
MEAN = 58
"""Row of the palette that most of the paint has: 0.92 of 63."""

_PAINT = 0.86, 0.98
"""Tones of the darkest and the lightest block."""

_EDGE = 0.35
"""Tone of edges: dark, but not as dark as a gap."""


_IS_EDGE = np.isin(np.arange(TILES * PIXELS) % PIXELS, (0, PIXELS - 1))
"""Mask of the pixels along a side of an image that are the first or the last one of a tile."""


def top(rng: np.random.Generator) -> Array:
    """Return the tones, 0 black to 1 white, of the tops of TILES x TILES blocks."""
    tones = one_per_image(rng, TILES * TILES, *_PAINT).reshape(TILES, TILES)
    tones = tones.repeat(PIXELS, axis=0).repeat(PIXELS, axis=1)
    return np.where(_IS_EDGE[:, None] | _IS_EDGE, _EDGE, tones)


def side(rng: np.random.Generator) -> Array:
    """Return the tones of the sides of TILES blocks, with an edge at their top."""
    tones = np.tile(one_per_image(rng, TILES, *_PAINT).ravel().repeat(PIXELS), (TILES * PIXELS, 1))
    tones[:, _IS_EDGE] = _EDGE
    tones[0] = _EDGE
    return tones
