"""rsegen respawn: the map of the running simulation replaced by the next one."""

from __future__ import annotations

import argparse
from dataclasses import asdict

from rsegen.cli.report import Report, Subparsers, add_command, call
from rsegen.commands.spawn import respawn
from rsegen.params.command import add_flags


def add(commands: Subparsers) -> None:
    """Add the parser of this command."""
    epilog = (
        "Robots and their programs go on; models on the map are put on top of the new blocks while the world is paused."
    )
    command = add_command(commands, "respawn", respawn, epilog=epilog)
    where = "the recipe of the current map, or the folder of its maps; after the last map of a folder comes the first"
    command.add_argument("target", metavar="RECIPE-or-DIR", help=where)
    add_flags(command.add_argument_group("respawn"), respawn)


def run(arguments: argparse.Namespace) -> Report:
    """Replace it, and give the names of both maps."""
    from rsegen.exporters.gazebo.sdf import numbers

    result = call(respawn, arguments, arguments.target)
    on_top = f"; put on top of it: {', '.join(result.put_on_top)}" if result.put_on_top else ""
    at = numbers([result.at.x, result.at.y, result.at.z])
    line = f"{result.name} replaces {result.instead_of}, at {at}{on_top}"
    return Report(lines=[line], content=asdict(result))
