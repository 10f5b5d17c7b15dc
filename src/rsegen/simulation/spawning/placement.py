"""Free ground for a new model in a simulation."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain, count, product
from math import hypot
from typing import NamedTuple

GAP = 0.5
"""Metres between a new model and those that are there."""


class Rectangle(NamedTuple):
    """An axis-aligned rectangle: its centre, and half of its length and width, metres."""

    x: float
    y: float
    half_x: float = 0.0
    half_y: float = 0.0

    def is_clear_of(self, other: Rectangle) -> bool:
        """Whether there is a gap between both."""
        return (
            abs(self.x - other.x) > self.half_x + other.half_x + GAP - 1e-3
            or abs(self.y - other.y) > self.half_y + other.half_y + GAP - 1e-3
        )


def free_rectangle(half_x: float, half_y: float, occupied: Sequence[Rectangle]) -> Rectangle:
    """The rectangle nearest to the origin, on a grid around it, that is clear of all taken ones."""
    run_trial = (
        Rectangle(round(i * (2 * half_x + GAP), 3), round(j * (2 * half_y + GAP), 3), half_x, half_y)
        for i, j in chain.from_iterable(map(_ring, count()))
    )
    return next(place for place in run_trial if all(map(place.is_clear_of, occupied)))


def _ring(number: int) -> Iterator[tuple[int, int]]:
    """The cells of a grid around the origin, the nearest first; east and north before west and south."""
    line = range(-number, number + 1)
    cells = (cell for cell in product(line, line) if max(map(abs, cell)) == number)
    return iter(sorted(cells, key=lambda cell: (hypot(*cell), -cell[0], -cell[1])))
