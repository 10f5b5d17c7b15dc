"""Friction between two surfaces is the smaller of their coefficients, as in both Gazebos; MuJoCo has no such rule.

It takes the coefficient of the shape with the higher priority, or else the larger of both. So each coefficient of the
map is a bit in the masks by which MuJoCo decides what may touch what, and each shape of a robot is there twice at most:

    rough    priority 1, with its own coefficient, touches the parts of the map that are no smoother than itself
    smooth   priority 0, without friction, touches the others, of which the coefficient then is the larger one

Cost: none on a map of one coefficient, where one shape is enough. What breaks it: a map with more than 28 coefficients,
which is refused.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from rsegen.errors import ParameterError

_MOST = 28
"""Coefficients of a map at most: masks have 31 bits, one of which is for robots that touch each other."""

ROBOTS = 1 << 30
"""The bit of robots, which touch each other."""

LEAST = 1e-5
"""The least coefficient: MuJoCo takes none of 0."""


class Layer(NamedTuple):
    """A shape of a robot as MuJoCo sees it: its priority and coefficient, and what it touches as bits."""

    priority: int
    mu: float
    touches: int


class MapFriction:
    """The coefficients of friction of a map, each of which has a bit."""

    def __init__(self, coefficients: Sequence[float]) -> None:
        if len(coefficients) > _MOST:
            problem = f"{len(coefficients)} different coefficients; MuJoCo can drive on a map with up to {_MOST}"
            raise ParameterError("level_friction", problem)
        self.largest = max(coefficients)
        self._bits = {mu: 1 << number for number, mu in enumerate(coefficients)}

    def bit(self, mu: float) -> int:
        """Return the bit of a coefficient of the map."""
        return self._bits[mu]

    def layers(self, mu: float) -> Iterator[Layer]:
        """Yield the layers of a shape of a robot with its own coefficient; the first touches other robots too."""
        rougher = sum(bit for own, bit in self._bits.items() if own >= mu)
        smoother = sum(bit for own, bit in self._bits.items() if own < mu)
        if rougher:
            yield Layer(1, max(mu, LEAST), rougher)
        if smoother and len(self._bits) == 1:
            yield Layer(1, max(min(self._bits), LEAST), smoother)
        elif smoother:
            yield Layer(0, LEAST, smoother)
