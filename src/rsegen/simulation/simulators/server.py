"""A headless server that has loaded a world, for whoever wants to drive, measure or change what is in it."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar

from rsegen.errors import SimulatorFailed
from rsegen.simulation.simulators.base import Installation, LaunchCommand, OpenRequest
from rsegen.simulation.simulators.live_world import LiveWorld
from rsegen.simulation.simulators.process import RunningProgram, output_of, running

TIMEOUT = 20.0
"""Seconds for a world to load, and for a server to answer."""

ATTEMPTS = 4
"""Gazebo 11.1's server now and then dies or hangs."""

Made = TypeVar("Made")


@dataclass(frozen=True, kw_only=True, slots=True)
class Server:
    """A running server; `home` is its own and goes with it, `launch` is what it was started by."""

    here: Installation
    launch: LaunchCommand
    home: Path
    running: RunningProgram

    @property
    def pid(self) -> int:
        """Of its process."""
        return self.running.process.pid

    @property
    def environment(self) -> Mapping[str, str]:
        """What a program needs beside its own variables to reach this server and no other."""
        return self.launch.environment

    @property
    def log(self) -> str:
        """All that it has said."""
        return log_of(self.home).read_text(errors="replace")

    @property
    def errors(self) -> list[str]:
        """The error lines of its log, without the harmless ones."""
        return self.here.simulator.error_lines(self.log)

    def connect(self) -> AbstractContextManager[LiveWorld]:
        """Its world, to be changed, for as long as it is asked."""
        return self.here.simulator.connect(self.environment)

    def wait_until_loaded(self, timeout: float = TIMEOUT) -> None:
        """Wait for its world; SimulatorFailed where the server dies, says that it has none, or takes too long."""
        end = time.monotonic() + timeout
        while not self.here.simulator.is_loaded(self.home, self.log):
            if self.running.exit_code is not None or time.monotonic() > end:
                raise self.lost(
                    "the server has died" if self.running.exit_code is not None else "it did not load in time"
                )
            time.sleep(0.02)
        if self.here.simulator.load_failed(self.log):
            raise self.lost("the world was not loaded")

    def told(self, name: str, *arguments: str, timeout: float = TIMEOUT) -> str:
        """What one of the installation's commands prints, asked about this server; it ends within `timeout` s."""
        command = (str(self.here.commands[name]), *arguments)
        try:
            return output_of(replace(self.launch, command=command), timeout)
        except SimulatorFailed as error:
            raise self.lost(str(error)) from None

    def stop(self) -> None:
        """Have it finish what it writes, and go."""
        self.running.end()

    def lost(self, why: str) -> SimulatorFailed:
        """The error that says why, and how the log ends."""
        return SimulatorFailed("\n".join([f"{self.here}: {why}; its log ends with:", *self.log.splitlines()[-20:]]))


@contextmanager
def running_server(
    here: Installation,
    world: Path,
    *,
    models: Path | None = None,
    options: tuple[str, ...] = (),
    timeout: float = TIMEOUT,
    screen: bool = False,
) -> Iterator[Server]:
    """A server that has loaded a world, in which time stands still; it is gone with all its processes when this ends.

    It disturbs no other: its home, its address and its log are its own. `models` is the folder where model:// is looked
    for, by default the one above the world's; `options` are the server's own, before the world; with
    `screen` it may draw.
    """
    with tempfile.TemporaryDirectory(prefix="rsegen-") as name:
        home = Path(name)
        opening = OpenRequest(world=world, models=models, screen=screen)
        launch = here.simulator.paused(here, opening, home).with_options(*options)
        with log_of(home).open("w") as log, running(launch, log) as process:
            server = Server(here=here, launch=launch, home=home, running=process)
            server.wait_until_loaded(timeout)
            yield server


def retried(once: Callable[[], Made], attempts: int = ATTEMPTS) -> Made:
    """What `once` gives, tried again where it loses its server; what the last attempt raises is raised."""
    try:
        return once()
    except SimulatorFailed:
        if attempts == 1:
            raise
    return retried(once, attempts - 1)


def log_of(home: Path) -> Path:
    """Where a server with such a home writes what it says."""
    return home / "log"
