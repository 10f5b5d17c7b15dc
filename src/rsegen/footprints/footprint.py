"""The footprint of a robot: the rectangles that its parts cover, and how far each is above level ground."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, radians, tan
from typing import NamedTuple

TILT = radians(3)
"""Largest tilt at which a robot may rest at its start. A robot 40 cm wide then stands on heights that differ by 1 cm,
which are the gaps and tolerances of sawn blocks; a whole unit tilts it by far more."""

TOUCHING = 0.0005
"""Metres above level ground up to which a part counts as standing on it: less than the 2 mm by which the crawler's
tracks are higher than its road wheels, which are its supports."""


class Rectangle(NamedTuple):
    """A rectangle in the frame of a robot that heads along x, metres."""

    low_x: float
    low_y: float
    high_x: float
    high_y: float

    @classmethod
    def around(cls, length: float, width: float) -> Rectangle:
        """Return the rectangle of a length and a width around the origin."""
        return cls(-length / 2, -width / 2, length / 2, width / 2)

    @property
    def length(self) -> float:
        """Side along x."""
        return self.high_x - self.low_x

    @property
    def width(self) -> float:
        """Side along y."""
        return self.high_y - self.low_y

    @property
    def middle(self) -> tuple[float, float]:
        """Centre of the rectangle."""
        return (self.low_x + self.high_x) / 2, (self.low_y + self.high_y) / 2

    def covers(self, other: Rectangle) -> bool:
        """Return whether another rectangle is inside."""
        return (
            self.low_x <= other.low_x
            and self.low_y <= other.low_y
            and self.high_x >= other.high_x
            and self.high_y >= other.high_y
        )

    def grown(self, margin: float) -> Rectangle:
        """Return the rectangle with a margin on every side."""
        return Rectangle(self.low_x - margin, self.low_y - margin, self.high_x + margin, self.high_y + margin)

    def ahead(self, distance: float) -> Rectangle:
        """Return the rectangle moved along x."""
        return self._replace(low_x=self.low_x + distance, high_x=self.high_x + distance)


class Underside(NamedTuple):
    """A part of a robot from below: the rectangle that it covers, and its height above level ground, metres."""

    rectangle: Rectangle
    bottom: float


@dataclass(frozen=True, kw_only=True, slots=True)
class Footprint:
    """The ground that a robot covers, and how even it has to be, metres.

    undersides: all parts; those at a height of 0 are the supports that it stands on
    limit: the largest height difference under its supports
    climb: the highest step that it drives up
    most: the largest height difference under the whole robot
    """

    undersides: tuple[Underside, ...]
    limit: float
    climb: float
    most: float = inf

    @classmethod
    def of_size(cls, length: float, width: float) -> Footprint:
        """Return the footprint of a robot of a length and a width in metres, which stands on its whole rectangle."""
        limit = tan(TILT) * min(length, width) / 2
        whole = Underside(Rectangle.around(length, width), 0.0)
        return cls(undersides=(whole,), limit=limit, climb=limit)

    @property
    def outline(self) -> Rectangle:
        """The smallest rectangle around all parts."""
        low_x, low_y, high_x, high_y = zip(*(part.rectangle for part in self.undersides), strict=True)
        return Rectangle(min(low_x), min(low_y), max(high_x), max(high_y))
