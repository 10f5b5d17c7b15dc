"""Start poses of robots, next to a map or on top of it: level, and never inside a block."""

from __future__ import annotations

import numpy as np

from rsegen.field.spots import Footprint, Spot, even_spots
from rsegen.field.stepfield import StepField
from rsegen.simulation.simulators.live_world import Pose

GAP = 0.1
"""Metres between a robot and the map next to it, and between two robots."""

DROP_HEIGHT = 0.005
"""Metres above the ground at which robots start, so that they do not start inside it."""


def adjacent_pose(field: StepField, footprint: Footprint, aside: float = 0.0) -> Pose:
    """The pose on the ground west of the map, heading east, `aside` metres north of its centre line."""
    return Pose(x=-field.extent[0] / 2 - GAP - footprint.outline.high_x, y=aside, z=DROP_HEIGHT)


def spots_on_map(
    field: StepField, footprint: Footprint, count: int, rng: np.random.Generator, *, evenest: bool = False
) -> tuple[Spot, ...]:
    """Places for robots on a map, on which they stand level and do not overlap; ParameterError if there are too few.

    evenest: where no place is level, take the one with the least unevenness.
    """
    return even_spots(field, footprint, count, rng, gap=GAP, evenest=evenest)


def start_pose(spot: Spot) -> Pose:
    """The pose from which a robot falls onto a spot: no part of it is inside a block."""
    return Pose(x=spot.x, y=spot.y, z=spot.z + DROP_HEIGHT, yaw=spot.yaw)
