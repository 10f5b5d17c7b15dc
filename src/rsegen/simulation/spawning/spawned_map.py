"""A map as it stands in a simulation: what ground it covers, and how high it is under something."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, floor, sin

from rsegen.field.stepfield import StepField
from rsegen.simulation.simulators.live_world import Pose
from rsegen.simulation.spawning.placement import Rectangle


@dataclass(frozen=True, kw_only=True, slots=True)
class SpawnedMap:
    """A map under the name that it has there, and where its middle is; it stands upright."""

    name: str
    field: StepField
    at: Pose

    @property
    def rectangle(self) -> Rectangle:
        """The smallest along the axes that it lies in."""
        (x, y), c, s = self.field.extent, abs(cos(self.at.yaw)), abs(sin(self.at.yaw))
        return Rectangle(self.at.x, self.at.y, (x * c + y * s) / 2, (x * s + y * c) / 2)

    def covers(self, at: Pose, reach: float) -> bool:
        """Whether something at a place, which reaches so far around it, is above the map."""
        return all(abs(x) <= along / 2 + reach for x, along in zip(self._seen(at), self.field.extent, strict=True))

    def top(self, at: Pose, reach: float = 0.0) -> float:
        """The z of the highest block within a reach of a place; of the ground, where no block is."""
        along_x, along_y = (self._cells(axis, x, reach) for axis, x in enumerate(self._seen(at)))
        return self.at.z + float(self.field.heights[along_x, along_y].max(initial=0.0))

    def _cells(self, axis: int, x: float, reach: float) -> slice:
        """Along an axis, those within a reach of a place in the map's own axes."""
        from_edge = x + self.field.extent[axis] / 2
        first, last = (floor((from_edge + side) / self.field.block_width) for side in (-reach, reach))
        return slice(max(first, 0), max(last + 1, 0))

    def _seen(self, at: Pose) -> tuple[float, float]:
        """A place in the map's own axes, from its middle."""
        x, y, c, s = at.x - self.at.x, at.y - self.at.y, cos(self.at.yaw), sin(self.at.yaw)
        return x * c + y * s, y * c - x * s
