"""The systems that a world with robots names for Gazebo Sim.

Up to Fortress 6.7 the server loads its default systems only if the world file has no plug-in at all. Those of a robot
count, so time would run and nothing would fall.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from xml.etree.ElementTree import Element, fromstring

from rsegen.simulation.robots.plugins import system

ALWAYS = ("Physics", "UserCommands", "SceneBroadcaster")
"""The default systems of every version."""

_RENDERED = ("camera", "depth_camera", "rgbd_camera", "thermal_camera", "segmentation_camera", "gpu_lidar", "gpu_ray")
_OF_SENSORS = {"imu": "Imu", "contact": "Contact"} | dict.fromkeys(_RENDERED, "Sensors")
"""Type of a sensor -> its system."""

_NAME = re.compile(r"(gz::sim|ignition::gazebo)(?:::v\d+)?::systems::(\w+)")


def add_systems(world: Element, backend: str) -> None:
    """Add to a <world> the systems that its models need and that it does not name; none in Gazebo Classic."""
    if backend == "classic":
        return
    there = set(_named(world, backend))
    sensors = {_OF_SENSORS.get(sensor.get("type", ""), "") for sensor in world.iter("sensor")} - {""}
    for kind in (*ALWAYS, *sorted(sensors)):
        if kind not in there:
            world.append(fromstring(system(kind, backend)))  # noqa: S314  # ours


def _named(world: Element, backend: str) -> Iterator[str]:
    """The systems that a world names; Gazebo Sim still reads Fortress's names, and Fortress no later ones."""
    for plugin in world.findall("plugin"):
        found = _NAME.fullmatch(plugin.get("name", ""))
        if found and (backend == "sim" or found[1] == "ignition::gazebo"):
            yield found[2]
