"""Textures of blocks: images that repeat, made of numbers alone, the same pixels on every machine.

An image has TILES x TILES tiles, one per block, and is multiplied by the colour (tint) of a material. Nothing is
computed with sines or powers, whose last digits differ between machines.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from rsegen.exporters.textures import edged, pine
from rsegen.exporters.textures.images import png
from rsegen.field.stepfield import Array
from rsegen.params.streams import generator


class Textures(NamedTuple):
    """The PNG files of a look: `top` for the tops of blocks, `side` for their sides and for frames."""

    top: bytes
    side: bytes


LOOKS = {"levels": edged, "friction": edged, "wood": pine}


@lru_cache(maxsize=4)
def textures(look: str, seed: int) -> Textures:
    """The textures of a look, drawn from a seed."""
    made, rng = LOOKS[look], generator(seed, 0, "textures of blocks")
    return Textures(*(png(_indices(tones), made.PALETTE) for tones in (made.top(rng), made.side(rng))))


def mean_colour(look: str) -> tuple[float, float, float]:
    """The colour, 0..1, that the textures of a look have from afar."""
    red, green, blue = (round(float(part) / 255, 3) for part in LOOKS[look].PALETTE[LOOKS[look].MEAN])
    return red, green, blue


def _indices(tones: Array) -> Array:
    """Tones 0..1 as colours of a palette of 64."""
    return np.clip(np.rint(tones * 63), 0, 63).astype(np.uint8)
