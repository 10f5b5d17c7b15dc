"""A simulator in this process, in which robots glide over all blocks."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import cos, sin
from typing import ClassVar

from rsegen.robots.lookup import DrivableRobot
from rsegen.scene.scene import Scene
from rsegen.simulators.embedded import AS_DRAWN, AsBuilt, EmbeddedSimulator, EmbeddedWorld, LinkPoses, PlacedRobot
from rsegen.simulators.poses import Pose, Record


class AirWorld(EmbeddedWorld):
    """A world without blocks."""

    step_seconds: ClassVar[float] = 0.01

    def __init__(self, robots: Sequence[PlacedRobot], period: float) -> None:
        self._poses = {robot.name: robot.start for robot in robots}
        self._speeds = {robot.name: (0.0, 0.0) for robot in robots}
        self._steps, self._every = 0, round(period / self.step_seconds)
        self._record = [self._state()]

    def poses(self) -> Mapping[str, Pose]:
        """Return where they are."""
        return self._poses

    def drive(self, name: str, robot: DrivableRobot, v: float, w: float) -> None:
        """Set a robot's speeds."""
        self._speeds[name] = v, w

    def step(self, steps: int) -> None:
        """Move along."""
        for _ in range(steps):
            self._steps += 1
            for name, (v, w) in self._speeds.items():
                at, way = self._poses[name], v * self.step_seconds
                x, y, yaw = at.x + way * cos(at.yaw), at.y + way * sin(at.yaw), at.yaw + w * self.step_seconds
                self._poses[name] = Pose(x=x, y=y, z=at.z, yaw=yaw)
            if self._steps % self._every == 0:
                self._record.append(self._state())

    def _state(self) -> tuple[float, dict[str, list[float]]]:
        poses = {name: [at.x, at.y, at.z, at.roll, at.pitch, at.yaw] for name, at in self._poses.items()}
        return self._steps * self.step_seconds, poses

    def link_poses(self) -> LinkPoses:
        """Return none: robots have no links here."""
        return {name: {} for name in self._poses}

    def recorded(self) -> Record:
        """Return the record, and where robots are at the end."""
        return self._record if self._steps % self._every == 0 else [*self._record, self._state()]

    def shares(self) -> Mapping[str, Mapping[str, float]]:
        """Return none: nothing is touched."""
        return {name: {} for name in self._poses}

    def held_by(self, name: str) -> str | None:
        """Return None: nothing holds them."""
        return None

    def notes(self) -> Iterator[str]:
        """Yield what is left out."""
        yield "In Thin Air blocks have no weight."


class Air(EmbeddedSimulator):
    """A simulator whose name is before all others'."""

    name: ClassVar[str] = "air"
    title: ClassVar[str] = "Thin Air"
    how_to_install: ClassVar[tuple[str, ...]] = ()

    def version(self) -> str | None:
        """It is always there."""
        return "1"

    def world(
        self,
        scene: Scene,
        robots: Sequence[PlacedRobot],
        *,
        motors: str = "reaction",
        period: float = 0.05,
        built: AsBuilt = AS_DRAWN,
    ) -> EmbeddedWorld:
        """Return a world without blocks."""
        return AirWorld(robots, period)
