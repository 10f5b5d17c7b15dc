"""rsegen open: a world opened in an installed simulator."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING

from rsegen.cli.flags import add_input, add_target_recipe_flags
from rsegen.cli.report import Report, Subparsers, add_command, call
from rsegen.cli.targets import target_of, which_map
from rsegen.commands.open import open as open_world
from rsegen.errors import printable
from rsegen.params.command import add_flags, flags_in_errors

if TYPE_CHECKING:
    from rsegen.simulation.open_world import OpenedWorld

_OWN = ("simulator",)
"""Flags that say something else here than in a recipe."""


def add(commands: Subparsers) -> None:
    """Add the parser of this command."""
    epilog = "rsegen sim lists the installed simulators. Error lines of the simulator go to stderr."
    command = add_command(commands, "open", open_world, epilog=epilog)
    where = "a world file, the folder of a map or of maps, or a recipe (a temporary world is made)"
    add_input(command, where, name="target", metavar="WORLD-or-DIR-or-RECIPE")
    group = command.add_argument_group("open")
    add_flags(group, open_world)
    group.add_argument("--print", action="store_true", help="print the shell command and open nothing")
    add_target_recipe_flags(command, _OWN)


def run(arguments: argparse.Namespace) -> Report:
    """Open it, and wait until it ends."""
    from rsegen.simulation.open_world import launch_command
    from rsegen.simulation.worlds import world_of

    with flags_in_errors(open_world):
        target = target_of(arguments, _OWN)
        if arguments.print:
            here, shared = world_of(target, arguments.map), bool(arguments.shared)
            headless = bool(arguments.headless)
            launch = launch_command(here, str(target), arguments.simulator, headless=headless, shared=shared)
            return Report(lines=[launch.shell_line], content={"command": launch.shell_line})

    def started(world: OpenedWorld) -> None:
        address = " ".join(f"{name}={value}" for name, value in world.address)
        if not (arguments.quiet or arguments.json):
            lines = [f"{world.simulator}: {world.file}" + (f", at {address}" if address else "")]
            print(*lines, *which_map(arguments.target, arguments.map), sep="\n", flush=True)

    def failed(line: str) -> None:
        print(printable(line), file=sys.stderr, flush=True)

    result = call(open_world, arguments, target, on_start=started, on_error=failed)
    opened = {"simulator": result.world.simulator, "world": str(result.world.file)}
    ended = {"address": dict(result.world.address), "exit_code": result.exit_code, "errors": list(result.errors)}
    return Report(lines=[], content=opened | ended)
