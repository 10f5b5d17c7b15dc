"""A map in a simulation: the ground that it covers, and its height under a model."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, floor, sin

from rsegen.field.stepfield import StepField
from rsegen.simulation.simulators.live_world import Pose
from rsegen.simulation.spawning.placement import Rectangle


@dataclass(frozen=True, kw_only=True, slots=True)
class SpawnedMap:
    """A map under its name in the simulation, and the pose of its centre; it is upright."""

    name: str
    field: StepField
    at: Pose

    @property
    def rectangle(self) -> Rectangle:
        """The smallest axis-aligned rectangle around it."""
        (x, y), c, s = self.field.extent, abs(cos(self.at.yaw)), abs(sin(self.at.yaw))
        return Rectangle(self.at.x, self.at.y, (x * c + y * s) / 2, (x * s + y * c) / 2)

    def covers(self, at: Pose, reach: float) -> bool:
        """Whether a model at a pose, with this radius, is above the map."""
        return all(abs(x) <= along / 2 + reach for x, along in zip(self._seen(at), self.field.extent, strict=True))

    def top(self, at: Pose, reach: float = 0.0) -> float:
        """The z of the highest block within a radius of a pose; of the ground if there is no block."""
        along_x, along_y = (self._cells(axis, x, reach) for axis, x in enumerate(self._seen(at)))
        return self.at.z + float(self.field.heights[along_x, along_y].max(initial=0.0))

    def outside(self, x: float, y: float) -> tuple[float, float]:
        """The place in the world of one in the map's own axes, from its middle."""
        c, s = cos(self.at.yaw), sin(self.at.yaw)
        return self.at.x + x * c - y * s, self.at.y + x * s + y * c

    def _cells(self, axis: int, x: float, reach: float) -> slice:
        """Along an axis, those within a reach of a place in the map's own axes."""
        from_edge = x + self.field.extent[axis] / 2
        first, last = (floor((from_edge + side) / self.field.block_width) for side in (-reach, reach))
        return slice(max(first, 0), max(last + 1, 0))

    def _seen(self, at: Pose) -> tuple[float, float]:
        """A place in the map's own axes, from its middle."""
        x, y, c, s = at.x - self.at.x, at.y - self.at.y, cos(self.at.yaw), sin(self.at.yaw)
        return x * c + y * s, y * c - x * s
