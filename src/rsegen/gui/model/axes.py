"""Tick marks with metres along the sides of the map in the 3D view."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rsegen.exporters.numbers import decimal
from rsegen.field.stepfield import Array
from rsegen.gui.model.bounds import Bounds
from rsegen.gui.model.solid import Lines

_MARKS, _FEWEST = 6, 3
"""Numbers along the longer side of a map, and along one that is much shorter, where more would overlap."""

_BASES = (1, 2, 5)
_BELOW = 0.9
"""How far below the ground the texts are, in widths of the border."""


class Marks(NamedTuple):
    """places: (n, 3), metres, of the texts, below the ground, so that they are below it in views from the side;
    lines: the ticks themselves.
    """

    places: Array
    texts: list[str]
    lines: Lines


def tick_marks(bounds: Bounds, border: float) -> Marks:
    """Ticks across the border, x on the south side and y on the east."""
    west, east, south, north = bounds[:4]
    near, far, beyond = (np.array([east, south]) + at * np.array([1, -1]) for at in (0, border, 1.8 * border))
    longest = max(east - west, north - south)
    along_x, along_y = (
        round_numbers(low, high, max(_MARKS * min(1.5 * (high - low) / longest, 1), _FEWEST))
        for low, high in ((west, east), (south, north))
    )
    starts = [*((x, near[1]) for x in along_x), *((near[0], y) for y in along_y)]
    ends = [*((x, far[1]) for x in along_x), *((far[0], y) for y in along_y)]
    places = [*((x, beyond[1]) for x in along_x), *((beyond[0] + 0.8 * border, y) for y in along_y)]
    texts = [*_texts("x", along_x), *_texts("y", along_y)]
    pairs = np.arange(2 * len(starts)).reshape(2, -1).T
    return Marks(_at_height(places, -_BELOW * border), texts, Lines(_at_height([*starts, *ends], 0.0), pairs))


def round_numbers(low: float, high: float, marks: float = _MARKS) -> list[float]:
    """About so many round numbers in a range: multiples of 1, 2 or 5 times a power of ten."""
    rough = (high - low) / marks
    power = 10.0 ** np.floor(np.log10(rough))
    step = next((base * power for base in _BASES if base * power >= rough), 10 * power)
    first, last = (int(np.ceil(round(low / step, 6))), int(np.floor(round(high / step, 6))))
    return [round(number * step, 9) for number in range(first, last + 1)]


def _texts(axis: str, along: list[float]) -> list[str]:
    """The numbers as text, of which the last has the axis and the unit."""
    return [*map(decimal, along[:-1]), f"{axis} = {decimal(along[-1])} m"]


def _at_height(places: list[tuple[float, float]], z: float) -> Array:
    return np.array([(x, y, z) for x, y in places], dtype=np.float64).reshape(-1, 3)
