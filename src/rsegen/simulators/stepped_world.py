"""A world with robots that is simulated step by step, whether a server runs it or this process does."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import TypeAlias

from rsegen.robots.lookup import DrivableRobot
from rsegen.simulators.poses import Contact, Pose

Record: TypeAlias = list[tuple[float, dict[str, list[float]]]]
"""Simulated seconds, and the poses (x, y, z, roll, pitch, yaw) of models at that time, state by state."""


class SteppedWorld(ABC):
    """A world whose time advances only by `step`. SimulatorFailed if its physics fails."""

    @abstractmethod
    def poses(self) -> Mapping[str, Pose]:
        """Return the pose of every model, by its name."""

    @abstractmethod
    def drive(self, name: str, robot: DrivableRobot, v: float, w: float) -> None:
        """Have a robot drive at v, m/s forward, and w, rad/s counterclockwise, from now on."""

    @abstractmethod
    def step(self, steps: int) -> None:
        """Simulate this number of steps, as fast as possible."""

    def step_with_contacts(self, steps: int) -> Sequence[Contact]:
        """Step, and give the contacts of the first step; none if they are not watched."""
        self.step(steps)
        return ()
