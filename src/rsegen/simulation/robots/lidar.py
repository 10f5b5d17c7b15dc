"""A lidar that is computed on the processor in Classic and by the renderer in Gazebo Sim."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

from rsegen.simulation.robots.links import PoseTuple
from rsegen.simulation.robots.plugins import element


@dataclass(frozen=True, kw_only=True, slots=True)
class Lidar:
    """A plane of rays round its z axis; nearest and farthest, metres; rate in Hz; place in the robot's first link."""

    pose: PoseTuple
    rays: int
    nearest: float
    farthest: float
    rate: float

    def sdf(self, simulator: str) -> str:
        """Its <sensor>: `ray` in Classic; `gpu_lidar`, the only one that Gazebo Sim computes, there."""
        kind, tag = ("ray", "ray") if simulator == "classic" else ("gpu_lidar", "lidar")
        circle = element("min_angle", 0) + element("max_angle", 2 * pi - 2 * pi / self.rays)
        scan = element("scan", element("horizontal", element("samples", self.rays) + circle))
        reach = element("range", element("min", self.nearest) + element("max", self.farthest))
        pose = element("pose", " ".join(map(str, self.pose)))
        inside = pose + element("always_on", "true") + element("update_rate", self.rate) + element(tag, scan + reach)
        return f'        <sensor name="lidar" type="{kind}">{inside}</sensor>\n'
