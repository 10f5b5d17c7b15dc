"""Simulators that are libraries: they need no server and no window, and simulate in this process.

An embedded simulator is one file with one class under `@register`, of this folder or of a capability. It builds a world
from a scene and robots, and everything that can be driven in a Gazebo server can be driven in it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, TypeAlias

from rsegen.errors import NoSimulator, UnknownName, UserError
from rsegen.field.stepfield import Array
from rsegen.params.registry import Contract, Registry, is_own
from rsegen.robots.lookup import DrivableRobot
from rsegen.robots.parameters import MOTORS
from rsegen.scene.scene import Scene
from rsegen.simulators.base import SIMULATORS
from rsegen.simulators.poses import Pose, Record, SteppedWorld


@dataclass(frozen=True, kw_only=True, slots=True)
class PlacedRobot:
    """A robot with its name in the world and the pose of its origin at the start."""

    name: str
    robot: DrivableRobot
    start: Pose


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class AsBuilt:
    """Differences between a real map and its drawing.

    heights: (n_x, n_y), metres by which each block is higher than drawn, NaN for one as drawn, None if all are
    friction: by which every coefficient of friction is multiplied
    """

    heights: Array | None = None
    friction: float = 1.0


AS_DRAWN = AsBuilt()
"""A map without errors."""

LinkPoses: TypeAlias = Mapping[str, Mapping[str, Array]]
"""The pose of each link in the world, (4, 4), by the names of its robot and of the link."""


class EmbeddedWorld(SteppedWorld):
    """A world in this process, which keeps a record of its robots."""

    step_seconds: ClassVar[float]

    @abstractmethod
    def link_poses(self) -> LinkPoses:
        """Return the poses of all links now, for pictures."""

    @abstractmethod
    def recorded(self) -> Record:
        """Return the poses of all robots, every `period` seconds, and at the end."""

    @abstractmethod
    def shares(self) -> Mapping[str, Mapping[str, float]]:
        """Return, for each robot, the share of steps in which each of its parts (LINK::COLLISION) had contact.

        Those of `step_with_contacts` count; none were taken: no part is named.
        """

    @abstractmethod
    def held_by(self, name: str) -> str | None:
        """Return the part of a robot (LINK::COLLISION) that is pushed back most, against its heading; None if none."""

    @abstractmethod
    def notes(self) -> Iterator[str]:
        """Yield what a reader of the drive should know of its physics, a sentence each."""


class EmbeddedSimulator(ABC):
    """A simulator in this process.

    name: as `--simulator` takes it; title: for people; how_to_install: lines of advice where its library is missing;
    drives_without: what a drive in it does not give, in words
    """

    name: ClassVar[str]
    title: ClassVar[str]
    how_to_install: ClassVar[tuple[str, ...]]
    drives_without: ClassVar[tuple[str, ...]] = ()

    @property
    def backend(self) -> str:
        """The name of its physics: its own."""
        return self.name

    @abstractmethod
    def version(self) -> str | None:
        """Return the version of its library; None if it is not installed, NoSimulator if it cannot be used."""

    def refuse_missing(self) -> None:
        """Raise a NoSimulator if its library is not installed."""
        if self.version() is None:
            how = f"; to install it: {'; '.join(self.how_to_install)}" if self.how_to_install else ""
            raise NoSimulator(f"{self.title} is not installed{how}")

    @abstractmethod
    def world(
        self,
        scene: Scene,
        robots: Sequence[PlacedRobot],
        *,
        motors: str = MOTORS[0],
        period: float = 0.05,
        built: AsBuilt = AS_DRAWN,
    ) -> EmbeddedWorld:
        """Return the world of a scene with robots at their starts; period: seconds between two rows of the record.

        It is 0.05, or, where nobody reads a record, 1e9.
        """

    def show(
        self,
        scene: Scene,
        robots: Sequence[PlacedRobot],
        seconds: float | None,
        *,
        headless: bool,
        on_start: Callable[[], None],
    ) -> None:
        """Simulate a scene with robots that stand in real time, in a window unless `headless`.

        It ends when the window is closed, or after `seconds` of wall time; without either, never. on_start: called
        once before it begins. UserError if there is no window.
        """
        raise UserError(f"{self.title} has no window; drive in it with rsegen drive")

    def __str__(self) -> str:
        return f"{self.title} {self.version() or ''}".strip()


def _problem(cls: type[EmbeddedSimulator]) -> str:
    return f"has the name {cls.name!r}, which a simulator with a server has" if cls.name in SIMULATORS else ""


EMBEDDED: Registry[EmbeddedSimulator] = Registry(
    "embedded simulator",
    order=lambda simulator: not is_own(simulator),
    group="rsegen.embedded_simulators",
    contract=Contract(
        base=EmbeddedSimulator, names=lambda cls: (cls.name,), stored_object=lambda cls: cls(), check=_problem
    ),
)
"""Every simulator in this process, by its name; those of plug-ins last."""

register = EMBEDDED.register
"""Decorator of an embedded simulator, one of which is known by its name then."""


def embedded_simulator(name: str | None) -> EmbeddedSimulator | None:
    """Return the embedded simulator of a name, by default the first of rsegen's own; None if the name is a server's.

    UnknownName, which lists all simulators, for any other name.
    """
    if name is None:
        return next(iter(EMBEDDED.own() or EMBEDDED.values()), None)
    if name not in EMBEDDED and name not in SIMULATORS:
        # A user who writes "gazebo" is told the names of both.
        meant = [*SIMULATORS] if name.lower() in ("gazebo", "gz", "ign", "ignition") else []
        raise UnknownName.among("simulator", "simulator", name, (*EMBEDDED, *SIMULATORS), meant)
    return EMBEDDED.get(name)
