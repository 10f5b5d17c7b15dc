"""Friction between two surfaces is the smaller of their coefficients, as in both Gazebos; MuJoCo has no such rule.

It takes the coefficient of the shape with the higher priority, or else the larger of both. So each coefficient of the
map is a bit in the masks by which MuJoCo decides what may touch what, and each shape of a robot exists at most twice:

    rough    priority 1, with its own coefficient, touches the parts of the map that are no smoother than itself
    smooth   priority 0, without friction, touches the other parts, whose coefficient is then the larger one

Cost: none on a map of one coefficient, where one shape is enough. What breaks it: a map with more than 28 coefficients,
which is refused.

With motors as Gazebo Classic's, friction is also as there: a limit along and another across (`corner_ellipse`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import sqrt
from typing import NamedTuple

from rsegen.errors import ParameterError

_MOST = 28
"""Coefficients of a map at most: masks have 31 bits, one of which is for robots that touch each other."""

ROBOTS = 1 << 30
"""The bit of robots, which touch each other."""

LEAST = 1e-5
"""The least coefficient: MuJoCo takes none of 0."""


MOST_RATIO = 24.0
"""Ratio of mu times slip across and along from which on the smaller slip counts as none: an ellipse of friction is at
most sqrt(1 + 24) = 5 times as long as its box, as MuJoCo solves contacts with the square of that."""

STUCK = 1e-3
"""Slip, m/s, that a friction spent in full counts as: MuJoCo's contacts creep by less where they hold."""

SHARPNESS = 8
"""Power of the spent share of a friction: 0.8 of it counts as a sixth of a friction spent in full."""

STILL = 1e-6
"""Slip, m/s, times its coefficient, of a contact that neither slips nor is held, so that the ratio has a value."""


def corner_ellipse(
    halves: tuple[float, float], slips: tuple[float, float], spent: tuple[float, float]
) -> tuple[float, float]:
    """Return the half-axes of the ellipse that stands for a box of friction.

            mu2 |     , - ~ ~ - ,          Coulomb's friction, and MuJoCo's, has one limit in all directions together: a
            +---|--'+           '+---      wheel that spins has spent it, and is pushed aside by anything. ODE's, in
        . ' |   |   |             | ' .    Gazebo Classic, has a limit along and one across, each on its own: a box.
       -----+---+---+-------------+-----   MuJoCo takes no box, but an ellipse (mu e, mu2 e2) contains the box and meets
        ' . |   |   |    mu       | . '    its corners if 1 / e^2 + 1 / e2^2 = 1. What slips is held as much as possible
            +---|--,+           ,+---      against its slip, so of these ellipses the one with
                |     ' - _ _ - '          e^2 = 1 + mu2 slip2 / (mu slip) holds exactly as the box does, at its corner.

    So a wheel that spins with hardly any slip to the side still holds there as the box does. What does not slip is held
    by a force inside the box, and begins to slip at its nearer side: there the ellipse has to be as near, so a friction
    that is spent counts as a slip.

    halves: of the box, mu and mu2; slips: along and across, m/s; spent: shares of mu and mu2 that held a step before
    """
    (mu, mu2), (slip, slip2), (share, share2) = halves, slips, spent
    held = STUCK * share**SHARPNESS if share < 1 else STUCK
    held2 = STUCK * share2**SHARPNESS if share2 < 1 else STUCK
    ratio = (mu2 * abs(slip2) + held2 + STILL) / (mu * abs(slip) + held + STILL)
    ratio = min(max(ratio, 1 / MOST_RATIO), MOST_RATIO)
    return mu * sqrt(1 + ratio), mu2 * sqrt(1 + 1 / ratio)


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
        self._bits = {mu: 1 << index for index, mu in enumerate(coefficients)}

    def bit(self, mu: float) -> int:
        """Return the bit of a coefficient of the map."""
        return self._bits[mu]

    def layers(self, mu: float) -> Iterator[Layer]:
        """Yield the layers of a shape of a robot with its own coefficient; the first touches other robots too."""
        own = min(mu, self.largest)  # a shape rougher than all of the map is as rough as its roughest part
        yield Layer(1, max(own, LEAST), sum(bit for of_map, bit in self._bits.items() if of_map >= own))
        if smoother := sum(bit for of_map, bit in self._bits.items() if of_map < own):
            yield Layer(0, LEAST, smoother)
