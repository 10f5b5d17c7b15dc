"""Poses of models and contacts between them, as every simulator gives them, and a world that is simulated by steps."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias, TypeVar

from rsegen.field.stepfield import Array, StepField
from rsegen.standing.body import Body
from rsegen.standing.outlines import Spot
from rsegen.standing.spots import GAP

if TYPE_CHECKING:
    from rsegen.robots.lookup import DrivableRobot

DROP_HEIGHT = 0.005
"""Height, metres, above the ground at which robots start, so that they do not start inside it.

It is beyond contacts' penetration, some 1 mm for soft wheels; a longer fall would shake the robot.
"""


@dataclass(frozen=True, kw_only=True, slots=True)
class Pose:
    """Position of a model, metres, and its rotation about x, y and z, radians."""

    x: float
    y: float
    z: float
    roll: float = 0.0
    pitch: float = 0.0
    yaw: float = 0.0

    @classmethod
    def above(cls, spot: Spot) -> Pose:
        """Return the pose of a robot at rest at a spot, raised until no part of it is inside a block."""
        return cls(x=spot.x, y=spot.y, z=spot.z + DROP_HEIGHT, roll=spot.roll, pitch=spot.pitch, yaw=spot.yaw)

    @classmethod
    def of(cls, numbers: Sequence[float]) -> Pose:
        """Return the pose of x, y, z, roll, pitch and yaw, as a Record has them."""
        x, y, z, roll, pitch, yaw = numbers
        return cls(x=x, y=y, z=z, roll=roll, pitch=pitch, yaw=yaw)

    def distance(self, other: Pose) -> float:
        """Return the distance between the positions of both, metres."""
        return math.dist((self.x, self.y, self.z), (other.x, other.y, other.z))


def angles_of(w: float, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Return roll, pitch and yaw, radians, of a unit quaternion."""
    return (
        math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
        math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x)))),
        math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)),
    )


_Angle = TypeVar("_Angle", float, Array)


def wrapped(angle: _Angle) -> _Angle:
    """Return the angle, or angles, between -pi and pi."""
    return (angle + math.pi) % (2 * math.pi) - math.pi


def adjacent_pose(field: StepField, body: Body, aside: float = 0.0) -> Pose:
    """Return the pose on the ground west of the map, heading east, `aside` metres north of its centre line."""
    return Pose(x=-field.extent[0] / 2 - GAP - float(body.high[0]), y=aside, z=DROP_HEIGHT)


@dataclass(frozen=True, kw_only=True, slots=True)
class Contact:
    """Two collisions in contact, each MODEL::LINK::COLLISION, and the mean of their contact points, metres."""

    collisions: tuple[str, str]
    position: tuple[float, float, float]


Record: TypeAlias = list[tuple[float, dict[str, list[float]]]]
"""Simulated seconds, and the poses (x, y, z, roll, pitch, yaw) of models at that time, state by state."""


class SteppedWorld(ABC):
    """A world with robots whose time advances only by `step`, whether a server runs it or this process does.

    SimulatorFailed if its physics fails.
    """

    @abstractmethod
    def poses(self) -> Mapping[str, Pose]:
        """Return the pose of every model, by its name."""

    @abstractmethod
    def drive(self, name: str, robot: DrivableRobot, v: float, w: float) -> None:
        """Have a robot drive at v, m/s forward, and w, rad/s counterclockwise, from now on."""

    @abstractmethod
    def step(self, steps: int) -> None:
        """Simulate this number of steps, as fast as possible."""

    def step_with_contacts(self, steps: int) -> Sequence[Contact]:
        """Step, and give the contacts of the first step; none if they are not watched."""
        self.step(steps)
        return ()
