"""The interface to a world in any running simulator: time, poses, commands to robots, models spawned and deleted."""

from __future__ import annotations

import re
import time
from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import dataclass
from typing import ClassVar

from rsegen.errors import SimulatorFailed
from rsegen.robots.drives import PublishCommand
from rsegen.robots.lookup import DrivableRobot
from rsegen.simulators.inbox import Inbox
from rsegen.simulators.poses import Pose, Record, SteppedWorld


@dataclass(frozen=True, kw_only=True, slots=True)
class Clock:
    """Simulation time and wall time without pauses, seconds; the number of steps; whether the world is paused."""

    simulated: float
    real: float
    steps: int
    paused: bool


class RunningWorld(SteppedWorld):
    """A world in another process, in which time runs until it is paused."""

    @abstractmethod
    def unpause(self) -> None:
        """Let simulation time run, and wait until that is reported."""

    @abstractmethod
    def pause(self) -> None:
        """Stop simulation time, and wait until that is reported."""

    @abstractmethod
    def clock(self) -> Clock:
        """Return the clock now."""

    def last_poses(self) -> tuple[float, Mapping[str, Pose]]:
        """Return simulated seconds, and the poses of the models that moved then, from the last message.

        Empty until the first message; it costs a running server less than `poses`, and has the time of the poses.
        """
        return self.clock().simulated, self.poses()


class LiveWorld(RunningWorld):
    """A world in a running simulator. SimulatorFailed if the simulator has ended or does not answer.

    between_looks: seconds between two looks whether something is done; client: its connection; name: of the world, as
    in its file; backend: the name of its message and plug-in types, one of `rsegen.robots.BACKENDS`.
    """

    between_looks: ClassVar[float]
    client: Inbox
    name: str
    backend: str

    @property
    @abstractmethod
    def is_current(self) -> bool:
        """Return whether the server still runs, and is the only one at its address."""

    @abstractmethod
    def send_command(self, command: PublishCommand) -> None:
        """Send a command to a robot, and wait until it is received."""

    def drive(self, name: str, robot: DrivableRobot, v: float, w: float) -> None:
        """Have a robot drive at v, m/s forward, and w, rad/s counterclockwise, and wait until that is received."""
        self.send_command(robot.command(name, v, w, self.backend))

    def unpause(self) -> None:
        """Let simulation time run, and wait until the server reports it."""
        self._set_paused(paused=False)

    def pause(self) -> None:
        """Stop simulation time, and wait until the server reports it."""
        self._set_paused(paused=True)

    @abstractmethod
    def _set_paused(self, *, paused: bool) -> None:
        """Pause or unpause, and wait until the server reports it."""

    def record(self, names: Sequence[str]) -> None:  # not needed where the server keeps a record
        """Record the poses of these robots from now on, as `recorded` gives them."""

    def watch_contacts(self) -> bool:
        """Return whether `step_with_contacts` gives contacts, which it may do only after this was called."""
        return True

    def recorded(self) -> Record:
        """Return the record of the robots; empty where the server keeps one."""
        return []

    def stop_recording(self) -> None:  # not every server keeps one
        """Stop the server's record, which takes up to half of its time."""

    def frame_counter(self, source: str) -> Callable[[], int]:
        """Return a function that counts frames from now on; source: one of its simulator's `frames`."""
        raise SimulatorFailed(f"the frames of a {source} cannot be counted here")

    def mesh_files(self) -> Mapping[str, str]:
        """Return the URI of the first visual mesh of each model, as its SDF has it, by the model's name."""
        return {}

    @abstractmethod
    def movable(self) -> Set[str]:
        """Return the names of the models that are not static."""

    def move(self, name: str, pose: Pose) -> None:
        """Set the pose of a model, and wait until it is closer to it than to its previous one."""
        before = self._move(name, pose)

        def has_moved() -> bool:
            at = self.poses().get(name)
            return at is not None and at.distance(pose) <= at.distance(before)

        self._wait(f"{name} stays where it was", has_moved)

    def spawn(self, sdf: str, pose: Pose) -> None:
        """Spawn the model of an SDF text, and wait until it exists."""
        start = re.search(r"<model\s+name=['\"]([^'\"]+)['\"]", sdf)
        if not start:
            raise SimulatorFailed("no <model> in the SDF text to spawn")
        self._spawn(start[1], sdf, pose)
        self._wait(f"{start[1]} did not appear", lambda: start[1] in self.poses())

    def delete(self, name: str) -> None:
        """Delete a model, and wait until it is gone."""
        self._delete(name)
        self._wait(f"{name} is still there", lambda: name not in self.poses())

    @abstractmethod
    def _move(self, name: str, pose: Pose) -> Pose:
        """Have the pose of a model set, and return the one before; SimulatorFailed if there is no such model."""

    @abstractmethod
    def _spawn(self, name: str, sdf: str, pose: Pose) -> None:
        """Have the model of an SDF text, of this name, spawned."""

    @abstractmethod
    def _delete(self, name: str) -> None:
        """Have a model deleted."""

    def _wait(self, otherwise: str, done: Callable[[], bool]) -> None:
        """Ask until something is done; SimulatorFailed with `otherwise` as its reason when patience is over."""
        wait = self.client.patience.begin()
        while not done():
            if wait.is_over:
                raise SimulatorFailed(f"{self.client.title}: {otherwise} after {self.client.patience}")
            time.sleep(self.between_looks)
