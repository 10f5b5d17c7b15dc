"""Servers of simulators that rsegen starts, with a paused world to drive robots in.

A server has its own home, address and log, so that it disturbs no other and changes no settings, and it ends when
rsegen ends. Whether it has loaded its world is read from its home and log, as its exit code does not tell
(docs/gazebo.md).
"""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar

from rsegen.errors import NoSimulator, NothingRuns, SimulatorFailed
from rsegen.simulators.base import SIMULATORS, Installation, OpenRequest, Simulator, installations, plain_text
from rsegen.simulators.live_world import LiveWorld
from rsegen.simulators.patience import SECONDS, Patience
from rsegen.simulators.process import OutputFiles, Work, grouped_line
from rsegen.writing.programs import LaunchCommand, RunningProgram

_PAUSE = 0.02
"""Seconds between two looks at a server that loads: each reads its log."""

_ERRORS, _LINES = 5, 20
"""The last error lines, or else lines, of a log in a message: more hide the reason, which comes at the end."""

ATTEMPTS = 4
"""Servers that are tried, as Gazebo 11.1's now and then dies or hangs.

With fewer, long experiments stop sooner; with more, a world that cannot be loaded is reported later.
"""

Result = TypeVar("Result")


@dataclass(frozen=True, kw_only=True, slots=True)
class Server:
    """A running server: its installation, the command that started it, its temporary home, and its process."""

    here: Installation
    launch: LaunchCommand
    home: Path
    running: RunningProgram

    @property
    def patience(self) -> Patience:
        """Return the patience with a server that has loaded: messages are its progress, and one that hangs may spin."""
        return Patience(seconds=self.here.timeout, sign=self.here.timeout)

    @property
    def pid(self) -> int:
        """The id of its process."""
        return self.running.process.pid

    @property
    def environment(self) -> Mapping[str, str]:
        """The variables by which programs reach this server and no other."""
        return self.launch.environment

    @property
    def log(self) -> str:
        """The output until now, errors last."""
        return OutputFiles(folder=self.home).text

    @property
    def errors(self) -> list[str]:
        """The error lines of its log, no harmless ones; those that differ in numbers alone are one, with a count."""
        return list(grouped_line(self.here.simulator.error_lines(self.log)))

    @contextmanager
    def connect(self) -> Iterator[LiveWorld]:
        """Connect to its world."""
        with ExitStack() as stack:
            try:
                variables = os.environ | dict(self.environment)
                live = stack.enter_context(self.here.simulator.connect(variables, self.patience))
            except NothingRuns as error:
                raise self.failure(str(error)) from None
            yield live

    def wait_until_loaded(self, watch: Callable[[], None] = lambda: None) -> None:
        """Wait until its world is loaded; SimulatorFailed if the server dies, reports a failure, or does nothing more.

        `watch` is called often meanwhile, and may raise.
        """
        wait = replace(self.patience, works=Work(self.running, self.home)).begin()
        is_loaded = False
        while not is_loaded:
            has_died, is_over = self.running.exit_code is not None, wait.is_over
            # Read after its state: what it printed before it died is in the log.
            log = self.log
            is_loaded = self.here.simulator.is_loaded(self.home, log)
            if self.here.simulator.load_failed(log):
                raise self.failure("the world was not loaded")
            if has_died or (is_over and not is_loaded):
                late = f"it has not loaded its world, after {self.patience} without progress"
                raise self.failure("the server has died" if has_died else late)
            watch()
            time.sleep(0 if is_loaded else _PAUSE)

    def stop(self) -> None:
        """Let it finish its files, and end."""
        self.running.end()

    def failure(self, why: str) -> SimulatorFailed:
        """Return an error with the reason and the last error lines of the log, else its last lines."""
        lines = self.here.simulator.without_harmless(plain_text(self.log).splitlines())
        errors, lines = self.errors[-_ERRORS:], lines[-_LINES:]
        heading = "its last errors are" if errors else "its log ends with"
        return SimulatorFailed("\n".join([f"{self.here}: {why}; {heading}:", *(errors or lines)]))


@contextmanager
def running_server(  # options of a server
    here: Installation,
    world: Path,
    *,
    models: Path | None = None,
    options: tuple[str, ...] = (),
    screen: bool = False,
    watch: Callable[[], None] = lambda: None,
) -> Iterator[Server]:
    """Start a server that has loaded a world and is paused; it ends with all its processes when this ends.

    models: the folder of model:// URIs, by default the one above the world's; options: options of the server; screen:
    whether it may render; watch: called often while it loads, may raise.
    """
    # The folder is home and log of this server alone, and is deleted with it.
    with tempfile.TemporaryDirectory(prefix="rsegen-") as name:
        home = Path(name)
        opening = OpenRequest(world=world, models=models, screen=screen)
        launch = here.simulator.paused(here, opening, home).with_options(*options)
        with OutputFiles(folder=home).running(launch) as process:
            server = Server(here=here, launch=launch, home=home, running=process)
            server.wait_until_loaded(watch)
            yield server


def attempted(once: Callable[[], Result]) -> tuple[Result, int]:
    """Return the result of `once`, and how often it was called: again if its server fails, until the last attempt."""
    for attempt in range(1, ATTEMPTS):
        with suppress(SimulatorFailed):
            return once(), attempt
    try:
        return once(), ATTEMPTS
    except SimulatorFailed as error:
        raise SimulatorFailed(f"{error}; this was attempt {ATTEMPTS} of {ATTEMPTS}") from None


def choose_installation(made_for: str, name: str | None, timeout: float = SECONDS) -> Installation:
    """Return the installation of that name, else of the simulator that a map is made for, else the newest one."""
    if name is None:
        chosen = next(installations(first=made_for), None) or _missing(*SIMULATORS.values())
    else:
        simulator = SIMULATORS.named(name, "simulator")
        chosen = simulator.installation() or _missing(simulator)
    return replace(chosen, timeout=timeout)


def _missing(*able: Simulator) -> Installation:
    titles = " or ".join(simulator.title for simulator in able)
    hints = "; ".join(f"{simulator.title}: {simulator.how_to_install[0]}" for simulator in able)
    raise NoSimulator(f"{titles} is not installed; to install it: {hints} (see rsegen sim)")
