"""Free ground for a new model between the models of a simulation; its maps, with the blocks under a place."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain, count, product
from math import cos, dist, floor, hypot, sin
from typing import NamedTuple

from rsegen.field.stepfield import StepField
from rsegen.robots.base import ROBOTS
from rsegen.simulators.poses import Pose

_ROUNDING = 1e-3
"""Slack of a gap, metres: positions on the grid are rounded to millimetres."""

GAP = 0.5
"""Gap, metres, between a new model and those that are there: a small robot passes between them."""


class Area(NamedTuple):
    """An axis-aligned rectangle of ground: its centre, and half of its length and width, metres."""

    x: float
    y: float
    half_x: float = 0.0
    half_y: float = 0.0

    def is_clear_of(self, other: Area) -> bool:
        """Return whether there is a gap between both."""
        return (
            abs(self.x - other.x) > self.half_x + other.half_x + GAP - _ROUNDING
            or abs(self.y - other.y) > self.half_y + other.half_y + GAP - _ROUNDING
        )

    def overlaps(self, other: Area) -> bool:
        """Return whether both have ground in common, more than their edges."""
        return (
            abs(self.x - other.x) < self.half_x + other.half_x - _ROUNDING
            and abs(self.y - other.y) < self.half_y + other.half_y - _ROUNDING
        )


def free_area(half_x: float, half_y: float, occupied: Sequence[Area]) -> Area:
    """Return the area nearest to the origin, on a grid around it, that is clear of all occupied ones."""
    steps = 2 * half_x + GAP, 2 * half_y + GAP
    candidates = (
        Area(round(x, 3), round(y, 3), half_x, half_y)
        for x, y in chain.from_iterable(_annulus(*steps, away * min(steps)) for away in count())
    )
    return next(place for place in candidates if all(map(place.is_clear_of, occupied)))


def _annulus(step_x: float, step_y: float, inner: float) -> list[tuple[float, float]]:
    """Return the grid points in an annulus as wide as the smaller step, the nearest first; ties: east, then north."""
    outer = inner + min(step_x, step_y)
    xs, ys = ([i * step for i in range(-int(outer / step), int(outer / step) + 1)] for step in (step_x, step_y))
    points = [(x, y) for x, y in product(xs, ys) if inner <= hypot(x, y) < outer]
    return sorted(points, key=lambda point: (hypot(*point), -point[0], -point[1]))


@dataclass(frozen=True, kw_only=True, slots=True)
class SpawnedMap:
    """A map under its name in the simulation, and the pose of its centre; it is upright."""

    name: str
    field: StepField
    at: Pose

    @property
    def area(self) -> Area:
        """The smallest axis-aligned rectangle around it."""
        (x, y), c, s = self.field.extent, abs(cos(self.at.yaw)), abs(sin(self.at.yaw))
        return Area(self.at.x, self.at.y, (x * c + y * s) / 2, (x * s + y * c) / 2)

    def covers(self, at: Pose, radius: float) -> bool:
        """Return whether a model at a pose, with this radius, is above the map."""
        place = self._in_map_axes(at)
        return all(abs(x) <= along / 2 + radius for x, along in zip(place, self.field.extent, strict=True))

    def top(self, at: Pose, radius: float = 0.0) -> float:
        """Return the z of the highest block within a radius of a pose; of the ground if there is no block."""
        # Blocks under the square around the model; off the map a slice is empty, not counted from the end.
        window = []
        for x, along in zip(self._in_map_axes(at), self.field.extent, strict=True):
            first, last = (floor((x + along / 2 + side) / self.field.block_width) for side in (-radius, radius))
            window.append(slice(max(first, 0), max(last + 1, 0)))
        return self.at.z + float(self.field.heights[tuple(window)].max(initial=0.0))

    def outside(self, x: float, y: float) -> tuple[float, float]:
        """Return the place in the world of one in the map's own axes, from its middle."""
        c, s = cos(self.at.yaw), sin(self.at.yaw)
        return self.at.x + x * c - y * s, self.at.y + x * s + y * c

    def _in_map_axes(self, at: Pose) -> tuple[float, float]:
        """Return a place in the map's own axes, from its middle."""
        x, y, c, s = at.x - self.at.x, at.y - self.at.y, cos(self.at.yaw), sin(self.at.yaw)
        return x * c + y * s, y * c - x * s


GROUND = "ground_plane"
"""The name of the ground in Gazebo's worlds, on which everything may be placed."""

_RADIUS = 0.3
"""The assumed radius, metres, of a model that is not one of rsegen's robots: that of a robot of a Jackal's class.

A larger model may be put into a block; a smaller one is only put higher than need be, and falls.
"""


def occupied(poses: Mapping[str, Pose], maps: Sequence[SpawnedMap]) -> list[Area]:
    """Return the rectangles that models occupy; of a model that is not one of these maps, only the origin is known."""
    known = {spawned.name: spawned.area for spawned in maps}
    return [known.get(name) or Area(at.x, at.y) for name, at in poses.items() if name != GROUND]


def model_radius(name: str) -> float:
    """Return the radius, metres, of a model; rsegen's robots are known by the beginning of their names."""
    kind = next((robot for kind, robot in ROBOTS.items() if name.startswith(kind)), None)
    return hypot(*kind.size[:2]) / 2 if kind else _RADIUS


def crowded_robot_notes(
    at: Pose, radius: float, poses: Mapping[str, Pose], maps: Sequence[SpawnedMap]
) -> Iterator[str]:
    """Yield a warning for each model that a robot of this radius may touch at a place."""
    known = {GROUND, *(spawned.name for spawned in maps)}
    for name, other in poses.items():
        away = dist((other.x, other.y, other.z), (at.x, at.y, at.z))
        if name not in known and away < radius + model_radius(name):
            yield f"the origin of {name} is {away:.2f} m away; models that are inside each other are thrown apart"


def crowded_map_notes(new: SpawnedMap, maps: Sequence[SpawnedMap]) -> Iterator[str]:
    """Yield a warning for each map on whose ground a new map is."""
    # The rectangles around turned maps may overlap where their blocks do not, so this says no more than that.
    for other in maps:
        if other.area.overlaps(new.area):
            yield f"{new.name} is over the ground of {other.name}, so their blocks may be inside each other"
