"""A world opened for a person, in the simulator that fits, with its error lines told as they come."""

from __future__ import annotations

import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from rsegen.errors import NoSimulator, SimulatorFailed
from rsegen.simulation.simulators.base import SIMULATORS, Installation, LaunchCommand, Simulator, installations
from rsegen.simulation.simulators.process import running


def choose_installation(made_for: str, name: str | None) -> Installation:
    """The installation of that name, or else the newest, that opens maps whose recipe says `simulator: made_for`."""
    wanted = None if name is None else SIMULATORS.named(name, "--simulator")
    able = [each for each in SIMULATORS.values() if each.can_open(made_for)]
    if wanted is None:
        here = next((here for here in installations() if here.simulator in able), None)
        return here or _missing(*able)
    if wanted not in able:
        raise NoSimulator(f"this map opens in {_titles(able)} only: its recipe says simulator: {made_for}")
    return wanted.installation() or _missing(wanted)


def has_screen() -> bool:
    """Whether a window could be seen; only Linux says so."""
    return sys.platform != "linux" or any(map(os.environ.get, ("DISPLAY", "WAYLAND_DISPLAY")))


def opened(here: Installation, launch: LaunchCommand, *, seconds: float, tell: Callable[[str], None]) -> int | None:
    """Run a simulator until it ends, or for so many seconds; gives its exit code, None where it was ended by us.

    `tell` is given each of its error lines. SimulatorFailed, at once, where it says that it has no world.
    """
    end = time.monotonic() + seconds
    with tempfile.TemporaryDirectory(prefix="rsegen-") as folder:
        log = Path(folder, "log")
        with log.open("w") as output, running(launch, output) as program:
            for line in _lines(log, lambda: program.code is None and time.monotonic() < end):
                for complaint in here.simulator.error_lines(line):
                    tell(complaint)
                if here.simulator.load_failed(line):
                    raise SimulatorFailed(f"{here} did not load the world {launch.command[-1]}")
            return program.code


def _lines(log: Path, going: Callable[[], bool]) -> Iterator[str]:
    """The lines of a file as they come, as long as it goes on."""
    rest, more = "", True
    with log.open(errors="replace") as reading:
        while more:
            more = going()
            *whole, rest = (rest + reading.read()).split("\n")
            yield from whole
            time.sleep(0.1 if more else 0)
    yield rest


def _missing(*able: Simulator) -> Installation:
    remedies = "; ".join(f"{each.title}: {each.how_to_install[0]}" for each in able)
    raise NoSimulator(f"no {_titles(able)} here; to get it: {remedies} (rsegen sim says more)")


def _titles(able: list[Simulator] | tuple[Simulator, ...]) -> str:
    return " or ".join(each.title for each in able)
