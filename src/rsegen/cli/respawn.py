"""rsegen respawn: the map of the running simulation replaced by the next one."""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict

from rsegen.cli.flags import Subparsers
from rsegen.cli.simulation_flags import add_output_flag, add_running_flags, flags_in_errors
from rsegen.exporters.gazebo.sdf import numbers
from rsegen.simulation.spawning.respawn import RespawnResult, respawn


def add(commands: Subparsers) -> None:
    """Add the parser of this command."""
    command = commands.add_parser(
        "respawn",
        description="Replace the map of the running simulation by the next one, at the same pose. Robots and their "
        "programs go on; models on the map are put on top of the new blocks while the world is paused.",
    )
    where = "the recipe of the current map, or the folder of its maps; after the last map of a folder comes the first"
    command.add_argument("target", metavar="RECIPE-or-DIR", help=where)
    command.add_argument("--map", metavar="INDEX", help="new map, by its index or name (default: the next)")
    command.add_argument("--name", help="name of the model to replace, if several could be meant")
    add_output_flag(command)
    add_running_flags(command)
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Replace it, and print the names of both maps."""
    with flags_in_errors("map", "name", "simulator"):
        result = respawn(
            arguments.target,
            map=arguments.map,
            name=arguments.name,
            output=arguments.output,
            simulator=arguments.simulator,
        )
    print(json.dumps(asdict(result), indent=2) if arguments.json else _line(result))


def _line(result: RespawnResult) -> str:
    on_top = f"; put on top of it: {', '.join(result.put_on_top)}" if result.put_on_top else ""
    at = numbers([result.at.x, result.at.y, result.at.z])
    return f"{result.name} replaces {result.instead_of}, at {at}{on_top}"
