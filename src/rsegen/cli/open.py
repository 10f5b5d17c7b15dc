"""rsegen open: a world opened in an installed simulator."""

from __future__ import annotations

import argparse
import sys

from rsegen.cli.flags import Subparsers, add_target_recipe_flags
from rsegen.cli.simulation_flags import flags_in_errors, simulator_names
from rsegen.cli.targets import target_of
from rsegen.errors import printable
from rsegen.simulation.open_world import SECONDS, OpenedWorld, launch_command
from rsegen.simulation.open_world import open as open_world

_OWN = ("simulator",)
"""Flags that say something else here than in a recipe."""


def add(commands: Subparsers) -> None:
    """Add the parser of this command."""
    command = commands.add_parser(
        "open",
        description="Open a world in the newest installed Gazebo that supports it; Ctrl-C or closing the window ends "
        "it.",
        epilog="rsegen sim lists the installed simulators. Error lines of the simulator go to stderr.",
    )
    where = "a world file, the folder of a map or of maps, or a recipe (a temporary world is made)"
    command.add_argument("target", nargs="?", metavar="WORLD-or-DIR-or-RECIPE", help=where)
    command.add_argument("--map", metavar="INDEX", help="map, by its index or name (default: the first)")
    command.add_argument("--simulator", metavar="NAME", help=f"{simulator_names()} (default: the newest)")
    command.add_argument("--headless", action="store_true", help="run only the server, without a window")
    command.add_argument("--seconds", metavar="N", help="end after N seconds")
    command.add_argument(
        "--shared", action="store_true", help="use the default address, so that other programs can connect"
    )
    command.add_argument("--print", action="store_true", help="print the shell command and open nothing")
    add_target_recipe_flags(command, _OWN)
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Open it, and wait until it ends."""
    names = ("map", "simulator", "headless", "shared")
    given = {name: getattr(arguments, name) for name in names}
    with flags_in_errors(*names, "seconds", "print"):
        text = arguments.seconds
        seconds = None if text is None else SECONDS.check("seconds", SECONDS.parse(text))
        target = target_of(arguments, _OWN)
        if arguments.print:
            print(launch_command(target, **given).shell_line)
            return
        open_world(target, **given, seconds=seconds, on_start=_print_start, on_error=_print_error)


def _print_start(world: OpenedWorld) -> None:
    address = " ".join(f"{name}={value}" for name, value in world.address)
    print(f"{world.simulator}: {world.file}" + (f", at {address}" if address else ""), flush=True)


def _print_error(line: str) -> None:
    print(printable(line), file=sys.stderr, flush=True)
