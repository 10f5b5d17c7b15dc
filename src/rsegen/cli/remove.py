"""rsegen remove: models deleted from the running simulation."""

from __future__ import annotations

import argparse
from dataclasses import asdict

from rsegen.cli.report import Report, Subparsers, add_command, call
from rsegen.commands.spawn import remove
from rsegen.params.command import add_flags


def add(commands: Subparsers) -> None:
    """Add the parser of this command."""
    command = add_command(commands, "remove", remove)
    command.add_argument("names", nargs="+", metavar="NAME", help="name of a model in the simulation")
    add_flags(command, remove)


def run(arguments: argparse.Namespace) -> Report:
    """Delete them, and give their names."""
    from rsegen.simulation.simulators import SIMULATORS

    result = call(remove, arguments, *arguments.names)
    removed = ", ".join(result.removed)
    return Report(lines=[f"{removed} removed from {SIMULATORS[result.simulator].title}"], content=asdict(result))
