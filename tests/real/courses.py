"""Worlds in which robots drive beside each other, each in a lane of its own."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

from rsegen.driving.world_file import add_systems
from rsegen.robots.base import Robot
from rsegen.simulators.base import Installation
from rsegen.simulators.live_world import LiveWorld
from rsegen.simulators.poses import Pose
from rsegen.simulators.server import Server, attempted, running_server

LANE = 4.0
"""Metres from lane to lane."""

_SURFACE = "<surface><friction><ode><mu>1</mu><mu2>1</mu2></ode></friction></surface>"
_GROUND = "<plane><normal>0 0 1</normal><size>100 100</size></plane>"


@dataclass(frozen=True, kw_only=True, slots=True)
class Course:
    """Robots by their names, in lanes from y = 0 on, and a stair in front of each, as geometries with their places.

    afloat: metres above the ground, without gravity; 0: on the ground
    """

    robots: Mapping[str, Robot]
    stair: Sequence[tuple[str, str]] = ()
    afloat: float = 0.0

    def world(self, backend: str) -> str:
        """The world file for a simulator with these names of messages and plug-ins."""
        root = ElementTree.fromstring(self._text(backend))
        add_systems(root if (world := root.find("world")) is None else world, backend)
        return ElementTree.tostring(root, encoding="unicode")

    def _text(self, backend: str) -> str:
        return f"""\
<sdf version="1.6">
  <world name="course">
    <gravity>0 0 {0 if self.afloat else -9.8}</gravity>
    <physics type="ode">
      <max_step_size>0.001</max_step_size>
      <real_time_update_rate>10000</real_time_update_rate>
      <real_time_factor>10</real_time_factor>
    </physics>
{"".join(self._models(backend))}  </world>
</sdf>
"""

    def _models(self, backend: str) -> Iterator[str]:
        yield _fixed("ground", "0 0 0", _GROUND)
        for lane, (name, robot) in enumerate(self.robots.items()):
            yield robot.model(name, backend, (0, lane * LANE, self.afloat, 0, 0, 0))
            for step, (place, geometry) in enumerate(self.stair):
                yield _fixed(f"step_{lane}_{step}", place.format(y=lane * LANE), geometry)


def stair(distance: float, rises: Sequence[float]) -> list[tuple[str, str]]:
    """Steps of 0.6 m depth, the last of 5 m, as boxes from the ground up; the first at a distance, metres."""
    steps, top = [], 0.0
    for number, rise in enumerate(rises):
        top += rise
        depth = 5.0 if number == len(rises) - 1 else 0.6
        middle = distance + 0.6 * number + depth / 2
        steps.append((f"{middle} {{y}} {top / 2}", f"<box><size>{depth} 2 {top}</size></box>"))
    return steps


def driven(
    gazebo: Installation,
    folder: Path,
    course: Course,
    commands: Mapping[str, tuple[float, float]],
    steps: Sequence[int],
    *,
    stop_after: int | None = None,
) -> list[Mapping[str, Pose]]:
    """Poses after each run of steps; the robots go at v and turn at w from the first, and stand after `stop_after`."""

    def once() -> list[Mapping[str, Pose]]:
        poses = []
        with served(gazebo, course, folder) as (_, live):
            for run, count in enumerate(steps):
                for name, (v, w) in commands.items() if run in (0, stop_after) else ():
                    motion = (v, w) if run == 0 else (0.0, 0.0)
                    live.send_command(course.robots[name].command(name, *motion, live.backend))
                live.step(count)
                poses.append(live.poses())
        return poses

    return attempted(once)[0]


@contextmanager
def served(gazebo: Installation, course: Course, folder: Path) -> Iterator[tuple[Server, LiveWorld]]:
    """A server, and its world, which stands still."""
    file = folder / "course.world"
    file.write_text(course.world(gazebo.backend))
    with running_server(gazebo, file) as server, server.connect() as live:
        yield server, live


def _fixed(name: str, place: str, geometry: str) -> str:
    inside = f'<collision name="collision"><geometry>{geometry}</geometry>{_SURFACE}</collision>'
    return f"""\
    <model name="{name}">
      <static>true</static>
      <pose>{place} 0 0 0</pose>
      <link name="link">{inside}</link>
    </model>
"""
