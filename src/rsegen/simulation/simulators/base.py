"""What a simulator is: how it is found, how it is got where it is missing, and what has to be started to open a world.

A simulator is one file of this folder with one class under `@register`. It starts nothing itself: it says a `Launch`,
which can be printed, tested, or given to `process`.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import ClassVar, TypeVar

from rsegen.params.contract import Contract
from rsegen.params.registry import Registry
from rsegen.simulation.simulators.live import LiveWorld, Record

_MARKS = ("[Err]", "[error]", "Error [", "Error Code")
"""Of error lines: Gazebo's up to Harmonic, and from Ionic on; libsdformat's up to 9, and later."""

_COLOUR_CODE = re.compile(r"\x1b\[[0-9;]*m")


@dataclass(frozen=True, kw_only=True, slots=True)
class Launch:
    """A command, the variables that it needs beside those that are there, and the folder that it runs in."""

    command: tuple[str, ...]
    environment: Mapping[str, str]
    folder: Path

    @property
    def line(self) -> str:
        """The same for a shell."""
        variables = (f"{name}={shlex.quote(value)}" for name, value in self.environment.items())
        return " ".join(["cd", shlex.quote(str(self.folder)), "&&", *variables, shlex.join(self.command)])

    def with_options(self, *options: str) -> Launch:
        """The same with more options, before the world."""
        return replace(self, command=(*self.command[:-1], *options, self.command[-1]))


@dataclass(frozen=True, kw_only=True, slots=True)
class Opening:
    """A world to be opened, and how.

    models: the folder where model:// is looked for, by default the one above the world's; shared: at the address that
    other programs of this user look at, instead of one of its own; home: a folder that stands for the user's home;
    screen: a server alone may draw too, as its cameras do.
    """

    world: Path
    models: Path | None = None
    shared: bool = False
    home: Path | None = None
    screen: bool = False

    @property
    def folder(self) -> Path:
        """The world's."""
        return self.world.absolute().parent

    @property
    def home_variables(self) -> dict[str, str]:
        """Where a program with a home of its own leaves what it leaves."""
        return {"HOME": str(self.home), "TMPDIR": str(self.home)} if self.home else {}

    def model_path(self, variable: str) -> str:
        """The folder of models, before those that the user has in a variable."""
        own = str((self.models or self.folder.parent).absolute())
        return os.pathsep.join(filter(None, (own, os.environ.get(variable))))


@dataclass(frozen=True, kw_only=True, slots=True)
class Installation:
    """A simulator that is there: its version, and its commands by their names."""

    simulator: Simulator
    version: str
    commands: Mapping[str, Path]

    @property
    def dialect(self) -> str:
        """The name by which robots know it."""
        return self.simulator.dialect(self)

    def __str__(self) -> str:
        return f"{self.simulator.title} {self.version}"


class Simulator(ABC):
    """A program that opens worlds.

    name: as in a recipe's `simulator`; title: for people; generation: the newest is preferred; remedy: how to get it,
    in lines; address: the variables by which programs find one server among others; harmless: parts of error lines that
    say nothing against a world; unloaded: parts of lines that say that the world is not there.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    generation: ClassVar[int]
    remedy: ClassVar[tuple[str, ...]]
    address: ClassVar[tuple[str, ...]]
    harmless: ClassVar[tuple[str, ...]] = ()
    unloaded: ClassVar[tuple[str, ...]] = ()

    @abstractmethod
    def found(self) -> Installation | None:
        """What is installed of it here; None where nothing is, or something else of the same name."""

    @abstractmethod
    def windowed(self, here: Installation, opening: Opening) -> Launch | None:
        """What opens a world with a window; None where the window is not installed."""

    @abstractmethod
    def headless(self, here: Installation, opening: Opening) -> Launch:
        """What serves a world without a window."""

    @abstractmethod
    def standing(self, here: Installation, opening: Opening, home: Path) -> Launch:
        """The same in a world that stands still until it is told to go on, by a server with such a home."""

    @abstractmethod
    def is_loaded(self, home: Path, log: str) -> bool:
        """Whether a server that was started by `standing` has loaded its world, from the home and log that it has."""

    @abstractmethod
    def dialect(self, here: Installation) -> str:
        """The name by which robots know it, one of `rsegen.robots.SIMULATORS`."""

    @abstractmethod
    def live(self, environment: Mapping[str, str]) -> AbstractContextManager[LiveWorld]:
        """The world of the server that these variables lead to; SimulatorFailed where none answers."""

    def recording(self, period: float) -> tuple[str, ...]:
        """A server's options, with which it records poses every so many seconds; none where it cannot."""
        return ()

    def record(self, home: Path) -> Record | None:
        """What a server with such a home has recorded until its end; None where it cannot."""
        return None

    def opens(self, made_for: str) -> bool:
        """Whether it opens a map whose recipe says `simulator: made_for`."""
        return made_for in ("both", self.name)

    def complaints(self, log: str) -> list[str]:
        """The error lines of a log, without the harmless ones."""
        lines = _COLOUR_CODE.sub("", log).splitlines()
        told = (line.strip() for line in lines if any(mark in line for mark in _MARKS))
        return [line for line in told if not any(known in line for known in self.harmless)]

    def has_not_loaded(self, log: str) -> bool:
        """Whether a log says that the world is not there."""
        plain = _COLOUR_CODE.sub("", log)
        return any(words in plain for words in self.unloaded)


def on_path(name: str, *elsewhere: Path) -> Path | None:
    """Where a command is: on PATH, else in one of the given folders."""
    places = (shutil.which(name), *(shutil.which(name, path=str(folder)) for folder in elsewhere))
    return next((Path(place) for place in places if place), None)


SIMULATORS: Registry[Simulator] = Registry(
    "simulator",
    order=lambda simulator: -simulator.generation,
    package="rsegen.simulation.simulators",
    group="rsegen.simulators",
    contract=Contract(base=Simulator, names=lambda cls: (cls.name,), kept=lambda cls: cls()),
)
"""Every simulator by its name, the newest first."""

_Kind = TypeVar("_Kind", bound=type[Simulator])


def register(cls: _Kind) -> _Kind:
    """Make a simulator known by its name."""
    SIMULATORS.add(cls.name, cls())
    return cls


def installations() -> Iterator[Installation]:
    """Those that are installed here, the newest first; each is asked for its version when it is its turn."""
    return (here for simulator in SIMULATORS.values() if (here := simulator.found()))
