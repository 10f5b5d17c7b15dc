"""Where a robot drives: asked at every turn for a speed and a turn rate, from where it is."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from math import atan2, hypot, pi
from typing import ClassVar, NamedTuple

import numpy as np

from rsegen.simulators.live import Pose


class Motion(NamedTuple):
    """Metres a second forward, radians a second counterclockwise."""

    v: float
    w: float


_HARDLY = 0.2
"""Of the way that a robot should have come."""


class Route(ABC):
    """A way to drive; `period`: seconds from one decision to the next."""

    name: ClassVar[str]
    period: ClassVar[float]

    @abstractmethod
    def motion(self, at: Pose) -> Motion:
        """What to do for the next period."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Straight(Route):
    """Eastward along a line, turning back to it where the ground turns the robot."""

    name: ClassVar[str] = "straight"
    period: ClassVar[float] = 0.5

    speed: float
    turn: float
    line: float = 0.0
    """y of the line, metres."""

    def motion(self, at: Pose) -> Motion:
        """Towards a point on the line, half a metre ahead."""
        wanted = atan2(self.line - at.y, 0.5)
        return Motion(self.speed, _clipped(_turned(wanted - at.yaw) / self.period / 2, self.turn))


@dataclass(kw_only=True, slots=True)
class Wandering(Route):
    """At random over a rectangle about the origin, of half a length and a width in metres; at its rim back in.

    Speeds are uniform between a half and the whole, turn rates up to a half of what the robot can. Where it has hardly
    come on since the last decision, it backs away.
    """

    name: ClassVar[str] = "random"
    period: ClassVar[float] = 1.0

    speed: float
    turn: float
    half: tuple[float, float]
    rng: np.random.Generator
    before: Pose | None = None

    def motion(self, at: Pose) -> Motion:
        """Two numbers are drawn each time, whether they count or not."""
        quick, aside = self.rng.random(2)
        v, w = self.speed * (0.5 + 0.5 * quick), self.turn * (aside - 0.5)
        before, self.before = self.before, at
        if before and hypot(at.x - before.x, at.y - before.y) < _HARDLY * self.speed * self.period:
            self.before = None
            return Motion(-v, w)
        if abs(at.x) > self.half[0] or abs(at.y) > self.half[1]:
            away = _turned(atan2(-at.y, -at.x) - at.yaw)
            return Motion(v / 2, _clipped(away / self.period, self.turn))
        return Motion(v, w)


def _turned(angle: float) -> float:
    """The same angle between -pi and pi."""
    return (angle + pi) % (2 * pi) - pi


def _clipped(value: float, most: float) -> float:
    return max(-most, min(most, value))
