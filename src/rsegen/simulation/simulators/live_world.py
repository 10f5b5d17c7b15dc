"""A world in a running simulator, whichever it is: time, places, words to a robot, models put in and taken out."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass

from rsegen.errors import SimulatorFailed
from rsegen.simulation.robots.commands import Command

Record = list[tuple[float, dict[str, list[float]]]]
"""Second and poses (x, y, z, roll, pitch, yaw) of models, state by state."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Clock:
    """Seconds simulated, and seconds that passed meanwhile without pauses; steps done; whether time stands still."""

    simulated: float
    real: float
    steps: int
    paused: bool


@dataclass(frozen=True, kw_only=True, slots=True)
class Pose:
    """Where a model stands, metres, and how it is turned about x, y and z, radians."""

    x: float
    y: float
    z: float
    roll: float = 0.0
    pitch: float = 0.0
    yaw: float = 0.0


@dataclass(frozen=True, kw_only=True, slots=True)
class Contact:
    """Two collisions in contact, each MODEL::LINK::COLLISION, and the mean of their contact points, metres."""

    collisions: tuple[str, str]
    position: tuple[float, float, float]


class LiveWorld(ABC):
    """What can be done with a running world. SimulatorFailed where the simulator is gone, or does not answer.

    dialect: the name by which robots know the simulator, one of `rsegen.robots.SIMULATORS`.
    """

    backend: str

    @abstractmethod
    def send_command(self, command: Command) -> None:
        """Say something to a robot, which has heard it when this ends."""

    @abstractmethod
    def step(self, steps: int) -> None:
        """Simulate so many steps, as fast as the world's physics allows, in a world that stands still."""

    def step_with_contacts(self, steps: int) -> Sequence[Contact]:
        """The same, and what touched what in the first of these steps; nothing where the simulator does not tell."""
        self.step(steps)
        return ()

    @abstractmethod
    def unpause(self) -> None:
        """Let time run."""

    @abstractmethod
    def pause(self) -> None:
        """Let time stand still."""

    def stop_recording(self) -> None:  # noqa: B027  # not every server keeps one
        """Have the server keep no record from now on, which costs it up to half its time."""

    @abstractmethod
    def clock(self) -> Clock:
        """The time now."""

    @abstractmethod
    def poses(self) -> Mapping[str, Pose]:
        """Where every model stands, by its name."""

    @abstractmethod
    def movable(self) -> Set[str]:
        """The names of the models that are not static."""

    @abstractmethod
    def move(self, name: str, pose: Pose) -> None:
        """Put a model that is there somewhere else, and wait until it has left its place."""

    @abstractmethod
    def spawn(self, sdf: str, pose: Pose) -> None:
        """Put the model of an SDF text into the world, and wait until it is there."""

    @abstractmethod
    def delete(self, name: str) -> None:
        """Take a model out of the world, and wait until it is gone."""


def model_name(sdf: str) -> str:
    """The name of the model of an SDF text."""
    found = re.search(r"<model\s+name=['\"]([^'\"]+)['\"]", sdf)
    if not found:
        raise SimulatorFailed("there is no model in what is to be put into the world")
    return found[1]
