"""rsegen remove: models taken out of the simulation that runs."""

from __future__ import annotations

import argparse
import json

from rsegen.cli.flags import Subparsers
from rsegen.cli.maps import add_running_flags
from rsegen.errors import UnknownName
from rsegen.simulation.simulators.connecting import connected


def add(commands: Subparsers) -> None:
    """The parser of this command."""
    command = commands.add_parser(
        "remove",
        help="take models out of the simulation that runs",
        description="Take maps, robots and other models out of the simulation that runs; none of them "
        "where one is not there.",
    )
    command.add_argument("names", nargs="+", metavar="NAME", help="what it is called there")
    add_running_flags(command)
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Take them out, and say so."""
    names = list(dict.fromkeys(arguments.names))
    with connected(arguments.simulator) as (simulator, live):
        there = live.poses()
        for name in names:
            if name not in there:
                raise UnknownName.among("", "model", name, there)
        for name in names:
            live.delete(name)
    told = {"removed": names, "simulator": simulator.name}
    print(json.dumps(told, indent=2) if arguments.json else f"{', '.join(names)} out of {simulator.title}")
