"""What a robot can do on a map, as the plan shows it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rsegen.field.spots import Rectangle, Spot
from rsegen.field.stepfield import Array, Mask

EASTWARD, NORTHWARD = (255, 45, 149), (255, 140, 0)
"""The colours of ways from west to east, and from south to north."""


class Way(NamedTuple):
    """A way across: points (n, 2) [m], from one side to the other; whether it is from west to east; whether it is one
    that the robot cannot drive, whose highest step is the least.
    """

    points: Array
    is_eastward: bool
    is_too_steep: bool = False


class Reach(NamedTuple):
    """What a robot can do on a map.

    text: whether it crosses; region: (n_x, n_y), the blocks below it in the largest area, in which it can drive from
    every place to every other
    spots: even places, the first for a start and the second for a goal, of a robot that covers `outline`; maybe none
    """

    text: str
    region: Mask
    ways: tuple[Way, ...]
    spots: tuple[Spot, ...]
    outline: Rectangle


def corners(outline: Rectangle, spot: Spot) -> Array:
    """The corners (4, 2) of a robot at a spot, the two in front last [m]."""
    low_x, low_y, high_x, high_y = outline
    own = np.array([(low_x, high_y), (low_x, low_y), (high_x, low_y), (high_x, high_y)])
    c, s = np.cos(spot.yaw), np.sin(spot.yaw)
    return np.asarray(own @ np.array([[c, s], [-s, c]]) + (spot.x, spot.y))
