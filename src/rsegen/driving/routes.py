"""Routes: they return a speed and turn rate for a robot's pose, again and again.

Straight and AlongWay are pure pursuit: the robot drives the arc that leads to a point of its line a distance d ahead,

    w = 2 v sin(a) / d,    a the angle between its heading and that point

(Coulter, Implementation of the Pure Pursuit Path Tracking Algorithm, CMU-RI-TR-92-01, 1992). The way is a planned one
(standing/planner.py) or, if no way leads across, the straight lane on which the robot gets farthest. Wandering draws
motions at random. Cost: none next to the simulation. What breaks it: a robot that skids, as no error is summed up, and
bends closer together than the robot is long, which it cuts.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from math import atan2, cos, hypot, inf, radians, sin
from typing import ClassVar, NamedTuple

import numpy as np

from rsegen.field.stepfield import StepField
from rsegen.simulators.poses import Pose, wrapped
from rsegen.standing.body import Body
from rsegen.standing.planner import best_way
from rsegen.standing.ways import Way, ends_across


class Motion(NamedTuple):
    """Speed forward, m/s, and turn rate counterclockwise, rad/s."""

    v: float
    w: float


STOP = Motion(0.0, 0.0)

_AHEAD = 0.5
"""Least distance, metres, to the point of its line that a robot heads for: nearer it swings, farther it is late."""

_PERIODS_AHEAD = 3
"""Periods of driving to that point at least, so that the robot does not pass it before it decides again."""

_TURN_FIRST = radians(60)
"""Angle, radians, to the next point from which on a robot turns on the spot: an arc would lead it far off its way."""

_NEXT = 16
"""Next points of a way among which the nearest is looked for: with all, a bend could be skipped."""

_MIN_PROGRESS = 0.2
"""Share of the commanded distance below which a wandering robot backs away: more than a stuck one slips (SLOW)."""


class Route(ABC):
    """A way to drive, until a robot is at x = goal, metres; by default without an end.

    period: seconds between decisions, fewer of which steer worse and cost less wall time
    """

    name: ClassVar[str]
    period: ClassVar[float]
    goal: float = inf

    @abstractmethod
    def motion(self, at: Pose) -> Motion:
        """Return the motion for the next period."""

    def is_done(self, at: Pose) -> bool:
        """Return whether the robot is at the goal."""
        return at.x >= self.goal


@dataclass(frozen=True, kw_only=True, slots=True)
class Straight(Route):
    """A drive eastward along the line y = line, and back to it if the ground turns the robot, to x = goal; metres."""

    name: ClassVar[str] = "straight"
    period: ClassVar[float] = 0.5

    speed: float
    turn: float
    line: float
    goal: float = inf

    def motion(self, at: Pose) -> Motion:
        """Return an arc to a point of the line ahead (pure pursuit, Coulter 1992)."""
        if self.is_done(at):
            return STOP
        ahead = max(_AHEAD, _PERIODS_AHEAD * self.speed * self.period)
        aside = atan2(self.line - at.y, ahead) - at.yaw
        return Motion(self.speed, _clipped(2 * self.speed * sin(aside) / ahead, self.turn))


@dataclass(kw_only=True, slots=True)
class AlongWay(Route):
    """A drive along a way of points x and y to x = goal, metres; first the robot turns on the spot to the way.

    ahead: distance of the point that the robot heads for, metres; passed: the index of the point that it is at
    """

    name: ClassVar[str] = "way"
    period: ClassVar[float] = 0.25

    speed: float
    turn: float
    points: Sequence[tuple[float, float]]
    ahead: float
    goal: float = inf
    passed: int = 0

    def motion(self, at: Pose) -> Motion:
        """Return an arc to a point of the way ahead; a turn on the spot if that is too far to the side."""
        if self.is_done(at):
            return STOP
        x, y = self._target(at)
        aside = wrapped(atan2(y - at.y, x - at.x) - at.yaw)
        if abs(aside) > _TURN_FIRST:
            return Motion(0.0, _clipped(aside / self.period, self.turn))
        turn = _clipped(2 * self.speed * sin(aside) / self.ahead, self.turn)
        return Motion(self.speed * cos(aside), turn)

    def _target(self, at: Pose) -> tuple[float, float]:
        """Return the first point that is far enough from the robot, after the nearest of the next few."""
        away = [hypot(x - at.x, y - at.y) for x, y in self.points[self.passed :]]
        nearest = min(range(min(len(away), _NEXT)), key=away.__getitem__)
        beyond = next((k for k in range(nearest, len(away)) if away[k] >= self.ahead), len(away) - 1)
        self.passed += nearest
        return self.points[self.passed - nearest + beyond]


@dataclass(kw_only=True, slots=True)
class Wandering(Route):
    """A random drive over a rectangle about the origin; outside of it the robot turns back.

    Speeds are uniform between half and all of the robot's speed, turn rates up to half of its own to either side. A
    robot that has hardly come on since the last decision backs away. half: of the length and width, metres
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
        if before and hypot(at.x - before.x, at.y - before.y) < _MIN_PROGRESS * self.speed * self.period:
            self.before = None
            return Motion(-v, w)
        if abs(at.x) > self.half[0] or abs(at.y) > self.half[1]:
            away = wrapped(atan2(-at.y, -at.x) - at.yaw)
            return Motion(v / 2, _clipped(away / self.period, self.turn))
        return Motion(v, w)


def _clipped(value: float, most: float) -> float:
    return max(-most, min(most, value))


class PlannedWay(Way):
    """A way from west to east for a robot to follow: `points` is never empty.

    If no way leads across, they are the ends of the straight lane that gets farthest, west and east of the map.
    """

    __slots__ = ()

    def as_json(self) -> dict[str, object]:
        """Return the entry of drive.json."""
        if self.length is None or self.tilt is None or self.margin is None:
            return {"crosses": False, "reason": self.reason, "at": self.at}
        figures = {"length": self.length, "tilt": self.tilt, "margin": self.margin}
        places = {"drops": self.drops, "slips": self.slips}
        rounded = {name: [[round(x, 9), round(y, 9)] for x, y in at] for name, at in places.items()}
        least = {"margin_at": [round(along, 9) for along in self.margin_at]} if self.margin_at else {}
        return {"crosses": True, **{name: round(value, 9) for name, value in figures.items()}, **least, **rounded}

    def csv(self) -> Iterator[str]:
        """Yield the lines of a CSV file."""
        yield "x,y\n"
        for x, y in self.points.tolist():
            yield f"{x:.4f},{y:.4f}\n"


def planned_way(field: StepField, body: Body, best: str = "length") -> PlannedWay:
    """Return the best way of a robot across a field from west to east; best: one of rsegen.standing.lattice.BEST."""
    return followed(field, body, best_way(field, body, 0, best))


def followed(field: StepField, body: Body, way: Way) -> PlannedWay:
    """Return a way from west to east with points to follow: its own or, if it does not cross, of a straight lane."""
    parts = {part.name: getattr(way, part.name) for part in fields(way)}
    if not way.crosses:
        line = (way.at or (0.0, 0.0))[1]
        parts["points"] = np.array([(x, line) for x in ends_across(field, body, 0)])
    return PlannedWay(**parts)
