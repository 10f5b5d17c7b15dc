"""The scale bar of the 3D view: a round length that is about as wide as wanted."""

from __future__ import annotations

from math import floor, log10

from rsegen.exporters.numbers import decimal

_BASES = (5, 2, 1)


def round_length(most: float) -> float:
    """The largest length of 1, 2 or 5 times a power of ten up to a length, metres."""
    power = 10.0 ** floor(log10(most))
    return round(next((base * power for base in _BASES if base * power <= most * (1 + 1e-9)), power), 9)


def length_text(metres: float) -> str:
    """A length as text: in centimetres below a metre."""
    return f"{decimal(round(metres * 100, 4))} cm" if metres < 1 else f"{decimal(metres)} m"
