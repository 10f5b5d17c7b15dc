"""Poses of models, and contacts between them, as every simulator gives them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from rsegen.field.stepfield import StepField
from rsegen.standing.body import Body
from rsegen.standing.spots import GAP

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
    def above(cls, spot: Any) -> Pose:
        """Return the pose of a robot at rest at a spot, so much higher that no part of it is inside a block."""
        return cls(x=spot.x, y=spot.y, z=spot.z + DROP_HEIGHT, roll=spot.roll, pitch=spot.pitch, yaw=spot.yaw)

    def distance(self, other: Pose) -> float:
        """Return the distance between the positions of both, metres."""
        return math.dist((self.x, self.y, self.z), (other.x, other.y, other.z))


def adjacent_pose(field: StepField, body: Body, aside: float = 0.0) -> Pose:
    """Return the pose on the ground west of the map, heading east, `aside` metres north of its centre line."""
    return Pose(x=-field.extent[0] / 2 - GAP - float(body.high[0]), y=aside, z=DROP_HEIGHT)


@dataclass(frozen=True, kw_only=True, slots=True)
class Contact:
    """Two collisions in contact, each MODEL::LINK::COLLISION, and the mean of their contact points, metres."""

    collisions: tuple[str, str]
    position: tuple[float, float, float]
