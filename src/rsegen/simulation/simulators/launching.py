"""The installation that fits a map, and a simulator run for a person, with its error lines as they come."""

from __future__ import annotations

import os
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from rsegen.errors import NoSimulator, SimulatorFailed
from rsegen.simulation.simulators.base import SIMULATORS, Installation, LaunchCommand, Simulator, installations
from rsegen.simulation.simulators.output_files import OutputFiles


def choose_installation(made_for: str, name: str | None) -> Installation:
    """The installation of that name, else of what a map is made for, else the newest."""
    if name is None:
        return next(installations(first=made_for), None) or _missing(*SIMULATORS.values())
    wanted = SIMULATORS.named(name, "simulator")
    return wanted.installation() or _missing(wanted)


def has_screen() -> bool:
    """Whether a window can be shown; only on Linux can it be known that there is no screen."""
    return sys.platform != "linux" or any(map(os.environ.get, ("DISPLAY", "WAYLAND_DISPLAY")))


def run_until_end(
    here: Installation, launch: LaunchCommand, *, seconds: float, on_error: Callable[[str], None]
) -> int | None:
    """The exit code of a simulator that runs until it ends, or None if it was ended after `seconds`.

    `on_error` is called with each of its error lines. SimulatorFailed, at once, if it says that it has no world.
    """
    end = time.monotonic() + seconds
    with tempfile.TemporaryDirectory(prefix="rsegen-") as folder:
        output = OutputFiles(folder=Path(folder))
        with output.running(launch) as program:
            for line in output.lines(lambda: program.exit_code is None and time.monotonic() < end):
                for error in here.simulator.error_lines(line):
                    on_error(error)
                if here.simulator.load_failed(line):
                    raise SimulatorFailed(f"{here} did not load the world {launch.command[-1]}")
            return program.exit_code


def _missing(*able: Simulator) -> Installation:
    titles = " or ".join(each.title for each in able)
    hints = "; ".join(f"{each.title}: {each.how_to_install[0]}" for each in able)
    raise NoSimulator(f"{titles} is not installed; to install it: {hints} (see rsegen sim)")
