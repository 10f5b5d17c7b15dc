"""What a simulator is: how it is found, how it is got where it is missing, and what has to be started to open a world.

A simulator is one file of this folder with one class under `@register`. It starts nothing itself: it says a `LaunchCommand`,
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

from rsegen.params.registry import Registry
from rsegen.simulation.simulators.live_world import LiveWorld, Record

_MARKS = ("[Err]", "[error]", "Error [", "Error Code")
"""Of error lines: Gazebo's up to Harmonic, and from Ionic on; libsdformat's up to 9, and later."""

_COLOUR_CODE = re.compile(r"\x1b\[[0-9;]*m")


@dataclass(frozen=True, kw_only=True, slots=True)
class LaunchCommand:
    """A command, the variables that it needs beside those that are there, and the folder that it runs in."""

    command: tuple[str, ...]
    environment: Mapping[str, str]
    folder: Path

    @property
    def shell_line(self) -> str:
        """The same for a shell."""
        variables = (f"{name}={shlex.quote(value)}" for name, value in self.environment.items())
        return " ".join(["cd", shlex.quote(str(self.folder)), "&&", *variables, shlex.join(self.command)])

    def with_options(self, *options: str) -> LaunchCommand:
        """The same with more options, before the world."""
        return replace(self, command=(*self.command[:-1], *options, self.command[-1]))


@dataclass(frozen=True, kw_only=True, slots=True)
class OpenRequest:
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
    def backend(self) -> str:
        """The name by which robots know it."""
        return self.simulator.backend(self)

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
    how_to_install: ClassVar[tuple[str, ...]]
    address_variables: ClassVar[tuple[str, ...]]
    harmless_messages: ClassVar[tuple[str, ...]] = ()
    load_failures: ClassVar[tuple[str, ...]] = ()

    @abstractmethod
    def installation(self) -> Installation | None:
        """What is installed of it here; None where nothing is, or something else of the same name."""

    @abstractmethod
    def with_gui(self, here: Installation, opening: OpenRequest) -> LaunchCommand | None:
        """What opens a world with a window; None where the window is not installed."""

    @abstractmethod
    def headless(self, here: Installation, opening: OpenRequest) -> LaunchCommand:
        """What serves a world without a window."""

    @abstractmethod
    def paused(self, here: Installation, opening: OpenRequest, home: Path) -> LaunchCommand:
        """The same in a world that stands still until it is told to go on, by a server with such a home."""

    @abstractmethod
    def is_loaded(self, home: Path, log: str) -> bool:
        """Whether a server that was started by `standing` has loaded its world, from the home and log that it has."""

    @abstractmethod
    def backend(self, here: Installation) -> str:
        """The name by which robots know it, one of `rsegen.robots.SIMULATORS`."""

    @abstractmethod
    def connect(self, environment: Mapping[str, str]) -> AbstractContextManager[LiveWorld]:
        """The world of the server that these variables lead to; SimulatorFailed where none answers."""

    def record_options(self, period: float) -> tuple[str, ...]:
        """A server's options, with which it records poses every so many seconds; none where it cannot."""
        return ()

    def read_record(self, home: Path) -> Record | None:
        """What a server with such a home has recorded until its end; None where it cannot."""
        return None

    def can_open(self, made_for: str) -> bool:
        """Whether it opens a map whose recipe says `simulator: made_for`."""
        return made_for in ("both", self.name)

    def error_lines(self, log: str) -> list[str]:
        """The error lines of a log, without the harmless ones."""
        lines = _COLOUR_CODE.sub("", log).splitlines()
        told = (line.strip() for line in lines if any(mark in line for mark in _MARKS))
        return [line for line in told if not any(known in line for known in self.harmless_messages)]

    def load_failed(self, log: str) -> bool:
        """Whether a log says that the world is not there."""
        plain = _COLOUR_CODE.sub("", log)
        return any(words in plain for words in self.load_failures)


def on_path(name: str, *elsewhere: Path) -> Path | None:
    """Where a command is: on PATH, else in one of the given folders."""
    places = (shutil.which(name), *(shutil.which(name, path=str(folder)) for folder in elsewhere))
    return next((Path(place) for place in places if place), None)


SIMULATORS: Registry[Simulator] = Registry("simulator", order=lambda simulator: -simulator.generation)
"""Every simulator by its name, the newest first."""

_Kind = TypeVar("_Kind", bound=type[Simulator])


def register(cls: _Kind) -> _Kind:
    """Make a simulator known by its name."""
    SIMULATORS.add(cls.name, cls())
    return cls


def installations() -> Iterator[Installation]:
    """Those that are installed here, the newest first; each is asked for its version when it is its turn."""
    return (here for simulator in SIMULATORS.values() if (here := simulator.installation()))
