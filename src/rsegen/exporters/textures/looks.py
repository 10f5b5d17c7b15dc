"""Textures of blocks: images that repeat, made of numbers alone, the same pixels on every machine.

An image has TILES x TILES tiles, one per block, and is multiplied by the colour (tint) of a material. Nothing is
computed with sines or powers, whose last digits differ between machines.

    rng --pine.top, edged.side, ...--> tones 0..1 --64 steps--> indices into a palette --png--> bytes
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from rsegen.exporters.colours import Colour, rounded
from rsegen.exporters.textures import edged, pine
from rsegen.exporters.textures.images import png
from rsegen.params.streams import generator


class Textures(NamedTuple):
    """The PNG files of a look: `top` for the tops of blocks, `side` for their sides and for frames."""

    top: bytes
    side: bytes


_TONES = 63
"""Highest index of a palette of 64 colours: 6 bits per pixel, which the eye cannot tell from 8 on wood."""

LOOKS = {"levels": edged, "friction": edged, "wood": pine}


@lru_cache(maxsize=4)
def textures(look: str, seed: int) -> Textures:
    """Return the textures of a look, drawn from a seed."""
    made, rng = LOOKS[look], generator(seed, 0, "textures of blocks")
    rows = (np.clip(np.rint(tones * _TONES), 0, _TONES) for tones in (made.top(rng), made.side(rng)))
    return Textures(*(png(row.astype(np.uint8), made.PALETTE) for row in rows))


def mean_colour(look: str) -> Colour:
    """Return the colour, 0..1, that the textures of a look have from afar."""
    return rounded(float(part) / 255 for part in LOOKS[look].PALETTE[LOOKS[look].MEAN])
