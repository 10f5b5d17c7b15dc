"""The interface of a simulator: how to find and install it, the commands that open a world in it, and how to connect.

A simulator is one file of this folder with one class under `@register`. It starts nothing itself: it gives a
`LaunchCommand`, which can be printed, tested, or run by `process`. The installed ones are found by `installations`; the
running one is found, and kept connected, by `connecting`.
"""

from __future__ import annotations

import os
import re
import shutil
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from rsegen.params.registry import Contract, Registry, is_own
from rsegen.simulators.live_world import LiveWorld
from rsegen.simulators.patience import SECONDS, Patience
from rsegen.simulators.poses import Record
from rsegen.writing.programs import LaunchCommand

_MARKS = ("[Err]", "[error]", "Error [", "Error Code", "Library error for [", "error while loading shared libraries")
"""Marks of error lines: of Gazebo up to Harmonic, and since Ionic; of libsdformat up to 9, and later; of an
installation whose libraries do not fit each other."""

_LINE_START = re.compile(r"\[Err\]|\(\d{4}-\d\d-\d\d [\d:.]+\) \[")
"""The start of a line of Gazebo Sim: of errors alone up to Harmonic, and of every line since Ionic, with the time."""

_COLOUR_CODE = re.compile(r"\x1b\[[0-9;]*m")
"""An escape sequence of a terminal, by which Gazebo colours its lines."""


@dataclass(frozen=True, kw_only=True, slots=True)
class OpenRequest:
    """A world to open, and how.

    models: the folder of model:// URIs, by default the one above the world's; shared: at the default address, where
    other programs look, instead of one of its own; home: a folder to use instead of the user's home; screen: a server
    without a window may render too, for its cameras.
    """

    world: Path
    models: Path | None = None
    shared: bool = False
    home: Path | None = None
    screen: bool = False

    @property
    def folder(self) -> Path:
        """The folder of the world."""
        return self.world.absolute().parent

    @property
    def home_variables(self) -> dict[str, str]:
        """The variables that give a program its own home and temporary folder."""
        return {"HOME": str(self.home), "TMPDIR": str(self.home)} if self.home else {}

    def model_path(self, variable: str) -> str:
        """Return the folder of models, followed by the user's own folders in a variable."""
        own = str((self.models or self.folder.parent).absolute())
        return os.pathsep.join(filter(None, (own, os.environ.get(variable))))


@dataclass(frozen=True, kw_only=True, slots=True)
class Installation:
    """An installed simulator: its version, and its commands by their names.

    timeout: seconds without progress after which what it runs is given up
    """

    simulator: Simulator
    version: str
    commands: Mapping[str, Path]
    timeout: float = SECONDS

    @property
    def backend(self) -> str:
        """The name of its message and plug-in types, one of `rsegen.robots.BACKENDS`."""
        return self.simulator.backend(self)

    @property
    def drives_without(self) -> tuple[str, ...]:
        """The results that a drive in it lacks, in words."""
        return self.simulator.drives_without

    def __str__(self) -> str:
        return f"{self.simulator.title} {self.version}"


class Simulator(ABC):
    """A program that opens worlds.

    name: as in a recipe's `simulator`; title: for people; generation: the newest is preferred, of a plug-in only if
    none of rsegen's own is installed; how_to_install: lines of advice; address_variables: the variables that select
    one server among others; harmless_messages: parts of error lines that say nothing against a world; load_failures:
    parts of lines that say that the world was not loaded; drives_without: what a drive in it does not give, in words;
    frames: what draws frames that can be counted, of `camera` (a sensor of the model `eye`, named `link` and `camera`)
    and `window`; digits: significant ones of the poses in its record, None if they are enough.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    generation: ClassVar[int]
    how_to_install: ClassVar[tuple[str, ...]]
    address_variables: ClassVar[tuple[str, ...]]
    harmless_messages: ClassVar[tuple[str, ...]] = ()
    load_failures: ClassVar[tuple[str, ...]] = ()
    drives_without: ClassVar[tuple[str, ...]] = ()
    frames: ClassVar[tuple[str, ...]] = ()
    digits: ClassVar[int | None] = None

    @abstractmethod
    def installation(self) -> Installation | None:
        """Return the installation on this machine; None without one, or if its command is another program's."""

    @abstractmethod
    def with_gui(self, here: Installation, opening: OpenRequest) -> LaunchCommand | None:
        """Return the command that opens a world with a window; None if the window is not installed."""

    @abstractmethod
    def headless(self, here: Installation, opening: OpenRequest) -> LaunchCommand:
        """Return the command that runs a world in a server without a window."""

    @abstractmethod
    def paused(self, here: Installation, opening: OpenRequest, home: Path) -> LaunchCommand:
        """Return the command of a server with its own home, in which the world is paused."""

    @abstractmethod
    def is_loaded(self, home: Path, log: str) -> bool:
        """Return whether a server that was started by `paused` has loaded its world, by its home and log."""

    @abstractmethod
    def backend(self, here: Installation) -> str:
        """Return the name of its message and plug-in types, one of `rsegen.robots.BACKENDS`."""

    @abstractmethod
    def connect(self, environment: Mapping[str, str], patience: Patience) -> AbstractContextManager[LiveWorld]:
        """Connect to the world of the server at this address; NothingRuns if none gives a sign of being there."""

    def window(self, here: Installation, server: LaunchCommand) -> LaunchCommand | None:
        """Return the command of a window on the world of a running server; None if it cannot have one."""
        return None

    def with_contact_sensors(self, model: str) -> str:
        """Return the text of a <model> with the sensors that make its contacts known; by default none."""
        return model

    def record_options(self, period: float) -> tuple[str, ...]:
        """Options of a server that record poses with this period, seconds; none if it cannot."""
        return ()

    def read_record(self, home: Path) -> Record | None:
        """Return the record of a server with this home, after its end; None if it cannot.

        SimulatorFailed if it is not whole.
        """
        return None

    def error_lines(self, log: str) -> list[str]:
        """Return the error lines of a log, without harmless ones."""
        # A warning of libsdformat ends without a line break, so an error may stand behind it.
        lines = _LINE_START.sub(r"\n\g<0>", plain_text(log)).splitlines()
        errors = (line.strip() for line in lines if any(mark in line for mark in _MARKS))
        return self.without_harmless(errors)

    def without_harmless(self, lines: Iterable[str]) -> list[str]:
        """Return lines of a log without those that say nothing against a world."""
        return [line for line in lines if not any(harmless in line for harmless in self.harmless_messages)]

    def load_failed(self, log: str) -> bool:
        """Return whether a log says that the world was not loaded."""
        plain = plain_text(log)
        return any(words in plain for words in self.load_failures)


def plain_text(log: str) -> str:
    """Return a log without the codes of its colours."""
    return _COLOUR_CODE.sub("", log)


def commands_of(name: str, *elsewhere: Path) -> list[Path]:
    """Return the paths of all commands of a name: in the folders of PATH in order, then in the given ones."""
    paths: dict[Path, Path] = {}  # by the file itself, as /bin is often a link to /usr/bin
    for folder in (*os.environ.get("PATH", os.defpath).split(os.pathsep), *elsewhere):
        if place := shutil.which(name, path=str(folder)):
            paths.setdefault(Path(place).resolve(), Path(place))
    return list(paths.values())


SIMULATORS: Registry[Simulator] = Registry(
    "simulator",
    order=lambda simulator: (not is_own(simulator), -simulator.generation),
    package="rsegen.simulators",
    group="rsegen.simulators",
    contract=Contract(base=Simulator, names=lambda cls: (cls.name,), stored_object=lambda cls: cls()),
)
"""Every simulator by its name, the newest first; those of plug-ins last."""

register = SIMULATORS.register
"""Decorator of a simulator, one of which is known by its name then."""


def installations(first: str = "") -> Iterator[Installation]:
    """Return the installed simulators: first the one of this name, then the newest; each is looked for in its turn."""
    ordered = sorted(SIMULATORS.values(), key=lambda simulator: simulator.name != first)
    return (installation for simulator in ordered if (installation := simulator.installation()))
