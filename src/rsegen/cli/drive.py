"""rsegen drive: robots driven over a map in Gazebo, and how far each got."""

from __future__ import annotations

import argparse
import shlex
from itertools import chain

from rsegen.cli.flags import add_input, add_target_recipe_flags
from rsegen.cli.report import Report, Subparsers, add_command, call, checked_flags, robot_kinds, seconds_bar
from rsegen.cli.targets import target_of, which_map
from rsegen.commands.drive import drive
from rsegen.params.command import add_flags, default, flags_in_errors

_OWN = ("simulator",)
"""Flags that say something else here than in a recipe."""


def add(commands: Subparsers) -> None:
    """Add the parser of this command."""
    epilog = (
        "The burger, which drives by default, gets over no frame; the crawler does; --boundary none leaves them out. "
        "rsegen sim lists the installed simulators. With --obstacle alone, --seed is also that of the map. "
    )
    command = add_command(commands, "drive", drive, epilog=epilog + robot_kinds())
    add_input(
        command, "a world made by rsegen, its folder, or a recipe", name="target", metavar="WORLD-or-DIR-or-RECIPE"
    )
    add_flags(command.add_argument_group("drive"), drive)
    add_target_recipe_flags(command, ("seed", *_OWN))


def run(arguments: argparse.Namespace) -> Report:
    """Drive, and report the metrics."""
    with flags_in_errors(drive):
        target = target_of(arguments, _OWN if arguments.target is None else ("seed", *_OWN))
    said = checked_flags(drive, arguments)
    with seconds_bar(said.get("duration", default(drive, "duration"))) as progress:
        result = call(drive, arguments, target, progress=progress)
    played = [f"to see it drive: rsegen gui {shlex.quote(str(said['output']))}"] if "output" in said else []
    notes = which_map(arguments.target, arguments.map)
    return Report(lines=chain(result.report(), played), content=result.as_json, notes=notes)
