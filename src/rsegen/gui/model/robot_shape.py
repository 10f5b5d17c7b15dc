"""The shape of a robot, and where it stands next to a map to be compared with it."""

from __future__ import annotations

from typing import NamedTuple

from rsegen.field.stepfield import Array
from rsegen.gui.model.bounds import Bounds


class RobotPart(NamedTuple):
    """A solid of a robot: the sides of a box, radius and length of a cylinder, or the radius of a sphere [m].

    pose: (4, 4), from the solid's frame, its centre in the origin and a cylinder along z, to that of the robot, whose
    origin is on the ground; colour: 0..1
    """

    sizes: tuple[float, ...]
    pose: Array
    colour: tuple[float, float, float]


class RobotShape(NamedTuple):
    """The parts of a robot, and its overall length, width and height [m]."""

    parts: tuple[RobotPart, ...]
    size: tuple[float, float, float]


def place_next_to(found: Bounds, rim: float, shape: RobotShape) -> tuple[float, float]:
    """Where a robot stands on the ground, south-east of a map, where neither blocks nor the axes' numbers hide it."""
    _, east, south, *_ = found
    length, width, _ = shape.size
    return east + rim / 2 + length / 2, south - rim / 2 - width / 2
