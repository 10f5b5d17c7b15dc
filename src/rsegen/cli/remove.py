"""rsegen remove: models deleted from the running simulation."""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict

from rsegen.cli.flags import Subparsers
from rsegen.cli.simulation_flags import add_running_flags, flags_in_errors
from rsegen.simulation.simulators import SIMULATORS
from rsegen.simulation.spawning.respawn import remove


def add(commands: Subparsers) -> None:
    """Add the parser of this command."""
    command = commands.add_parser(
        "remove",
        description="Delete maps, robots and other models from the running simulation; none of them if one does not "
        "exist.",
    )
    command.add_argument("names", nargs="+", metavar="NAME", help="name of a model in the simulation")
    add_running_flags(command)
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Delete them, and print their names."""
    with flags_in_errors("simulator"):
        result = remove(*arguments.names, simulator=arguments.simulator)
    removed = ", ".join(result.removed)
    print(
        json.dumps(asdict(result), indent=2)
        if arguments.json
        else f"{removed} removed from {SIMULATORS[result.simulator].title}"
    )
