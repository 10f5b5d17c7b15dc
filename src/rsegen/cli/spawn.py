"""rsegen spawn: a map or a robot put into the running simulation."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from dataclasses import asdict, astuple

from rsegen.cli.flags import Subparsers, add_target_recipe_flags
from rsegen.cli.simulation_flags import add_output_flag, add_running_flags, flags_in_errors
from rsegen.cli.targets import target_of
from rsegen.errors import ParameterError, shown
from rsegen.exporters.gazebo.sdf import numbers
from rsegen.robots import ROBOTS
from rsegen.simulation.simulators import SIMULATORS
from rsegen.simulation.spawning.spawn import METRES, SpawnResult, spawn

_OWN = ("simulator", "name")
"""Flags that say something else here than in a recipe."""


def add(commands: Subparsers) -> None:
    """Add the parser of this command."""
    command = commands.add_parser(
        "spawn",
        description="Spawn a map or a robot in the running simulation: Gazebo Classic's at GAZEBO_MASTER_URI, or "
        "Gazebo Sim's in GZ_PARTITION, or at their default addresses.",
        epilog="Kinds of robots: " + ", ".join(ROBOTS) + ". rsegen open --shared starts a simulation.",
    )
    where = "the folder of a map or of maps, a recipe, a kind of robot, or the SDF file of a robot"
    command.add_argument("target", nargs="?", metavar="DIR-or-RECIPE-or-ROBOT-or-SDF", help=where)
    command.add_argument("--map", metavar="INDEX", help="map, by its index or name (default: the first)")
    command.add_argument("--name", help="name of the model (default: the map's name, or the kind of robot)")
    place = "pose in metres and radians, as in --at=-2,0 (default: the free place nearest to the origin, or "
    place += "of a robot's file an even place on the map)"
    command.add_argument("--at", metavar="X,Y[,Z[,YAW]]", help=place)
    add_output_flag(command)
    add_running_flags(command)
    add_target_recipe_flags(command, _OWN)
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Spawn it, and print its name and pose."""
    with flags_in_errors("map", "name", "at", "simulator"):
        result = spawn(
            target_of(arguments, _OWN),
            map=arguments.map,
            name=arguments.name,
            at=None if arguments.at is None else _numbers(arguments.at),
            output=arguments.output,
            simulator=arguments.simulator,
        )
    print(json.dumps(asdict(result), indent=2) if arguments.json else "\n".join(_lines(result)))


def _numbers(text: str) -> list[float]:
    parts = text.split(",")
    if not 2 <= len(parts) <= 4:
        raise ParameterError("at", f"{shown(text)} is not X,Y or X,Y,Z or X,Y,Z,YAW")
    return [METRES.check("at", METRES.parse(part)) for part in parts]


def _lines(result: SpawnResult) -> Iterator[str]:
    x, y, z, _, _, yaw = astuple(result.at)
    on_top = f"; put on top of it: {', '.join(result.put_on_top)}" if result.put_on_top else ""
    where = f"{SIMULATORS[result.simulator].title} at {numbers([x, y, z])}, turned by {numbers([yaw])} rad"
    yield f"{result.name} is in {where}{on_top}"
    yield from (f"note: {line}" for line in result.notes)
