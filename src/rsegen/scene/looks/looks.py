"""Textures of blocks: images that repeat, made of numbers alone, the same pixels on every machine.

An image has TILES x TILES tiles, one per block, and is multiplied by the colour (tint) of a material. Nothing is
computed with sines or powers, whose last digits differ between machines.

    rng --pine.top, edged.side, ...--> tones 0..1 --64 steps--> indices into a palette --png--> bytes
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from rsegen.params.streams import generator
from rsegen.scene.colours import Colour, rounded_colour
from rsegen.scene.looks import edged, pine
from rsegen.scene.looks.images import png

_TONES = 63
"""Highest index of a palette of 64 colours: 6 bits per pixel, which the eye cannot tell from 8 on wood."""

LOOKS = {"levels": edged, "friction": edged, "wood": pine}


@lru_cache(maxsize=4)
def textures(look: str, seed: int) -> tuple[bytes, bytes]:
    """Return the PNG files of a look, drawn from a seed: of the tops of blocks, and of their sides and of frames."""
    made, rng = LOOKS[look], generator(seed, 0, "textures of blocks")
    tops, sides = (np.clip(np.rint(tones * _TONES), 0, _TONES) for tones in (made.top(rng), made.side(rng)))
    return png(tops.astype(np.uint8), made.PALETTE), png(sides.astype(np.uint8), made.PALETTE)


def mean_colour(look: str) -> Colour:
    """Return the colour, 0..1, that the textures of a look have from afar."""
    return rounded_colour(float(part) / 255 for part in LOOKS[look].PALETTE[LOOKS[look].MEAN])
