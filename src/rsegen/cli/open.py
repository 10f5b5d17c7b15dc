"""rsegen open: a world in the simulator that is here."""

from __future__ import annotations

import argparse
import math
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rsegen.cli.flags import Subparsers
from rsegen.cli.worlds import World, world_of
from rsegen.errors import NoSimulator, ParameterError, SimulatorFailed
from rsegen.params.sorts import Float
from rsegen.simulation.simulators import SIMULATORS, Installation, LaunchCommand, OpenRequest
from rsegen.simulation.simulators.launching import choose_installation, has_screen, opened

SECONDS = Float(0, 1e9, unit="s")


def add(commands: Subparsers) -> None:
    """The parser of this command."""
    command = commands.add_parser(
        "open",
        help="open a world in Gazebo",
        description="Open a world in the newest Gazebo that is here and can; Ctrl-C or closing the window ends it.",
        epilog="rsegen sim lists the simulators that are here. Error lines of the simulator go to stderr.",
    )
    where = "a world file, the folder of a map or of maps, or a recipe, of which a world is made for the time being"
    command.add_argument("target", metavar="WORLD-or-DIR-or-RECIPE", help=where)
    command.add_argument("--map", metavar="INDEX", help="which map, by its index or its name (default: the first)")
    names = " or ".join(f"{name} ({each.title})" for name, each in SIMULATORS.items())
    command.add_argument("--simulator", metavar="NAME", help=f"{names}, the newest by default")
    command.add_argument("--headless", action="store_true", help="without a window: the server alone")
    command.add_argument("--seconds", metavar="N", help="end after so many seconds")
    command.add_argument(
        "--shared", action="store_true", help="at the usual address, where other programs look, and not at one alone"
    )
    command.add_argument("--print", action="store_true", help="print the line for a shell, and open nothing")
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Open it, and stay until it ends."""
    seconds = math.inf if arguments.seconds is None else SECONDS.check("--seconds", SECONDS.parse(arguments.seconds))
    world = world_of(arguments.target, arguments.map)
    here = choose_installation(world.made_for, arguments.simulator)
    if arguments.print:
        print(_line(here, world, arguments))
        return
    if not (arguments.headless or has_screen()):
        raise NoSimulator("open: there is no screen here (neither DISPLAY nor WAYLAND_DISPLAY is set); give --headless")
    with _home(headless=arguments.headless) as home, world.on_disk() as file:
        opening = OpenRequest(world=file, shared=arguments.shared, home=home)
        launch = _launch(here, opening, headless=arguments.headless)
        print(f"{here}: {file}{_address(launch, here)}", flush=True)
        _stay(here, launch, seconds, headless=arguments.headless)


def _line(here: Installation, world: World, arguments: argparse.Namespace) -> str:
    if not world.file:
        raise ParameterError("--print", f"{arguments.target} has no world yet; make one with rsegen generate")
    return _launch(here, OpenRequest(world=world.file, shared=arguments.shared), headless=arguments.headless).line


def _launch(here: Installation, opening: OpenRequest, *, headless: bool) -> LaunchCommand:
    simulator = here.simulator
    launch = simulator.headless(here, opening) if headless else simulator.with_gui(here, opening)
    if not launch:
        raise NoSimulator(
            f"{here} is here without its window; give --headless, or get it: {simulator.how_to_install[0]}"
        )
    return launch


def _address(launch: LaunchCommand, here: Installation) -> str:
    """Where other programs reach it, if that is a place of its own."""
    own = [f"{name}={launch.environment[name]}" for name in here.simulator.address if name in launch.environment]
    return f", at {' '.join(own)}" if own else ""


@contextmanager
def _home(*, headless: bool) -> Iterator[Path | None]:
    """A home for a server alone, which so disturbs no other; a window has the user's, where its settings are."""
    if not headless:
        yield None
        return
    with tempfile.TemporaryDirectory(prefix="rsegen-") as home:
        yield Path(home)


def _stay(here: Installation, launch: LaunchCommand, seconds: float, *, headless: bool) -> None:
    """Until it ends; to be stopped is the usual way to do so.

    A window that is closed is no failure, though Gazebo Classic may then exit with 255; nor are complaints of a window.
    """
    error_lines: list[str] = []

    def tell(complaint: str) -> None:
        error_lines.append(complaint)
        print(complaint, file=sys.stderr, flush=True)

    try:
        code = opened(here, launch, seconds=seconds, tell=tell)
    except KeyboardInterrupt:
        code = None
    if code is not None and (headless or (code and error_lines)):
        raise SimulatorFailed(f"{here} ended by itself, with exit code {code}")
    if headless and error_lines:
        raise SimulatorFailed(f"{here} complained of the world: {error_lines[0]}")
