"""Routes: they give a speed and turn rate for a robot's pose, again and again.

The way across a map that the metrics find for a robot, as points that it can follow.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import atan2, cos, hypot, pi, radians, sin
from typing import ClassVar, NamedTuple

import numpy as np

from rsegen.field.metrics.traversability import crossing, percolation_step
from rsegen.field.robot_limits import RobotLimits
from rsegen.field.stepfield import Array, StepField
from rsegen.simulation.simulators.live_world import Pose


class Motion(NamedTuple):
    """Speed forward, m/s, and turn rate counterclockwise, rad/s."""

    v: float
    w: float


STOP = Motion(0.0, 0.0)

_AHEAD = 0.5
"""Metres."""

_TURN_FIRST = radians(60)
"""A robot whose way leads more to the side than this turns on the spot."""

_NEXT = 10
"""Points of a way among which the nearest is looked for, so that no bend of it is left out."""

_HARDLY = 0.2
"""Of the way that a robot should have come."""


class Route(ABC):
    """A way to drive; `period`: seconds between decisions."""

    name: ClassVar[str]
    period: ClassVar[float]

    @abstractmethod
    def motion(self, at: Pose) -> Motion:
        """The motion for the next period."""

    def is_done(self, at: Pose) -> bool:
        """Return whether the route has ended."""
        return False


@dataclass(frozen=True, kw_only=True, slots=True)
class Straight(Route):
    """A drive eastward along the line y = line, and back to it if the ground turns the robot, to x = goal; metres."""

    name: ClassVar[str] = "straight"
    period: ClassVar[float] = 0.5

    speed: float
    turn: float
    line: float
    goal: float

    def motion(self, at: Pose) -> Motion:
        """Return an arc to a point of the line ahead (pure pursuit, Coulter 1992)."""
        if at.x >= self.goal:
            return STOP
        ahead = max(_AHEAD, 3 * self.speed * self.period)
        aside = atan2(self.line - at.y, ahead) - at.yaw
        return Motion(self.speed, _clipped(2 * self.speed * sin(aside) / ahead, self.turn))

    def is_done(self, at: Pose) -> bool:
        """At the goal."""
        return at.x >= self.goal


@dataclass(kw_only=True, slots=True)
class AlongWay(Route):
    """A drive along a way of points x and y, at first on the spot to where it leads, to x = goal; metres.

    ahead: how far before it the robot heads for a point of the way; passed: the number of the point that it is at
    """

    name: ClassVar[str] = "way"
    period: ClassVar[float] = 0.25

    speed: float
    turn: float
    points: Sequence[tuple[float, float]]
    ahead: float
    goal: float
    passed: int = 0

    def motion(self, at: Pose) -> Motion:
        """Return an arc to a point of the way ahead; a turn on the spot if that is too far to the side."""
        if self.is_done(at):
            return STOP
        x, y = self._target(at)
        aside = _turned(atan2(y - at.y, x - at.x) - at.yaw)
        if abs(aside) > _TURN_FIRST:
            return Motion(0.0, _clipped(aside / self.period, self.turn))
        turn = _clipped(2 * self.speed * sin(aside) / self.ahead, self.turn)
        return Motion(self.speed * cos(aside), turn)

    def is_done(self, at: Pose) -> bool:
        """At the goal."""
        return at.x >= self.goal

    def _target(self, at: Pose) -> tuple[float, float]:
        """The first point that is far enough from the robot, after the nearest of the next few."""
        away = [hypot(x - at.x, y - at.y) for x, y in self.points[self.passed :]]
        nearest = min(range(min(len(away), _NEXT)), key=away.__getitem__)
        beyond = next((k for k in range(nearest, len(away)) if away[k] >= self.ahead), len(away) - 1)
        self.passed += nearest
        return self.points[self.passed - nearest + beyond]


@dataclass(kw_only=True, slots=True)
class Wandering(Route):
    """A random drive over a rectangle about the origin, half its length and width in metres; at its rim back in.

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
        """Return a random motion; two numbers are drawn each time, whether they count or not."""
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
    """Return the angle between -pi and pi."""
    return (angle + pi) % (2 * pi) - pi


def _clipped(value: float, most: float) -> float:
    return max(-most, min(most, value))


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class PlannedWay:
    """The cheapest way from west to east; where there is none for the robot, the one whose highest step is least.

    points: (n, 2), x and y in metres, from the ground west of the map to that east of it; crosses: whether the robot's
    limits allow it, None if they are unknown; least_step: of all ways, the least highest step, metres
    """

    points: Array
    crosses: bool | None
    least_step: float

    def __post_init__(self) -> None:
        self.points.setflags(write=False)

    def as_json(self) -> dict[str, object]:
        """Return the entry of drive.json."""
        return {"crosses": self.crosses, "least_step": round(self.least_step, 9)}

    def csv(self) -> Iterator[str]:
        """The lines of a CSV file."""
        yield "x,y\n"
        for x, y in self.points.tolist():
            yield f"{x:.4f},{y:.4f}\n"


def planned_way(field: StepField, width: float, limits: RobotLimits | None) -> PlannedWay:
    """The way across a field for a robot of a width in metres, with these limits if they are known."""
    least = percolation_step(field, width, 0)
    found = crossing(field, limits, 0) if limits else None
    path = found.path if found and found.crosses else crossing(field, RobotLimits.of(least, width), 0).path
    half = np.array(field.extent) / 2
    return PlannedWay(
        points=(path + 0.5) * field.block_width - half,
        crosses=found.crosses if found else None,
        least_step=least,
    )
