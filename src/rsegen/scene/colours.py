"""The colour of a height in plans, on the page, in pictures and on build sheets: the same on all standard maps.

It is lighter the higher, so that it reads in greyscale too. In worlds a level has its own colour (scene.py).

    height h [m] --h / (h + 0.35)--> place 0..1 on a ramp of six colours --in OKLab--> sRGB

The ramp has no end: 10, 20, 40 cm lie at 0.22, 0.36, 0.53 of it, 2 m at 0.85. Between its colours it goes straight in
OKLab (B. Ottosson, A perceptual color space for image processing, 2020), in which equal distances look alike. On maps
whose blocks are all below 20 cm, as for small robots, a tenth of the height has the colour, and of those below 2 cm a
hundredth: steps of 1 cm would look alike.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import lru_cache
from math import inf

Colour = tuple[float, float, float]

_RAMP: tuple[Colour, ...] = (
    (0.22, 0.20, 0.42),
    (0.17, 0.38, 0.60),
    (0.13, 0.58, 0.60),
    (0.45, 0.74, 0.38),
    (0.95, 0.84, 0.29),
    (0.99, 0.97, 0.84),
)

_MIDDLE = 0.35
"""The height [m] in the middle of the ramp: of the blocks of standard step fields half are lower."""

_LOW = 0.2
"""The height [m] below which all blocks of a low map are: those of standard step fields have 20 cm or more."""

_Lab = tuple[float, float, float]


@lru_cache(maxsize=4096)
def height_colour(height: float, highest: float = inf) -> Colour:
    """Return the colour of blocks of a height on a map whose highest blocks may have another [m], in sRGB."""
    middle = _MIDDLE / (1 if highest >= _LOW - 1e-9 else 10 if highest >= _LOW / 10 - 1e-9 else 100)
    return _srgb(ramp_colour([oklab(colour) for colour in _RAMP], max(height, 0.0) / (max(height, 0.0) + middle)))


def ramp_colour(ramp: Sequence[Colour], place: float) -> Colour:
    """Return the colour at a place, 0..1, on a ramp of colours, straight between two of them."""
    at = place * (len(ramp) - 1)
    low = min(int(at), len(ramp) - 2)
    x, y, z = (a + (at - low) * (b - a) for a, b in zip(ramp[low], ramp[low + 1], strict=True))
    return x, y, z


def rounded_colour(colour: Iterable[float], digits: int = 3) -> Colour:
    """Return a colour as files have it."""
    x, y, z = (round(part, digits) for part in colour)
    return x, y, z


def linear(colour: Colour) -> Colour:
    """Return the linear colour of an sRGB colour (IEC 61966-2-1)."""
    r, g, b = (part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in colour)
    return r, g, b


def oklab(colour: Colour) -> _Lab:
    """Return lightness 0..1 and the two opponent colours of a colour in sRGB."""
    r, g, b = linear(colour)
    long, middle, short = (
        (x * r + y * g + z * b) ** (1 / 3)
        for x, y, z in (
            (0.4122214708, 0.5363325363, 0.0514459929),
            (0.2119034982, 0.6806995451, 0.1073969566),
            (0.0883024619, 0.2817188376, 0.6299787005),
        )
    )
    return (
        0.2104542553 * long + 0.7936177850 * middle - 0.0040720468 * short,
        1.9779984951 * long - 2.4285922050 * middle + 0.4505937099 * short,
        0.0259040371 * long + 0.7827717662 * middle - 0.8086757660 * short,
    )


def _srgb(lab: _Lab) -> Colour:
    lightness, a, b = lab
    long, middle, short = (
        (lightness + x * a + y * b) ** 3
        for x, y in ((0.3963377774, 0.2158037573), (-0.1055613458, -0.0638541728), (-0.0894841775, -1.2914855480))
    )
    linear = (
        4.0767416621 * long - 3.3077115913 * middle + 0.2309699292 * short,
        -1.2684380046 * long + 2.6097574011 * middle - 0.3413193965 * short,
        -0.0041960863 * long - 0.7034186147 * middle + 1.7076147010 * short,
    )
    clipped = (min(max(part, 0.0), 1.0) for part in linear)
    red, green, blue = (12.92 * part if part <= 0.0031308 else 1.055 * part ** (1 / 2.4) - 0.055 for part in clipped)
    return red, green, blue
