"""rsegen spawn: a map or a robot put into the running simulation."""

from __future__ import annotations

import argparse
from dataclasses import asdict, astuple

from rsegen.cli.advice import in_flags
from rsegen.cli.flags import add_input, add_target_recipe_flags
from rsegen.cli.report import Report, Subparsers, add_command, call, robot_kinds
from rsegen.cli.targets import target_of, which_map
from rsegen.commands.spawn import spawn
from rsegen.params.command import add_flags, flags_in_errors

_OWN = ("simulator", "name")
"""Flags that say something else here than in a recipe."""


def add(commands: Subparsers) -> None:
    """Add the parser of this command."""
    epilog = (
        "Gazebo Classic is looked for at GAZEBO_MASTER_URI, Gazebo Sim in GZ_PARTITION, or at their default addresses. "
    )
    command = add_command(
        commands, "spawn", spawn, epilog=f"{epilog}rsegen open --shared starts a simulation. {robot_kinds()}"
    )
    where = "the folder of a map or of maps, a recipe, a kind of robot, or the SDF, URDF or Xacro file of a robot"
    add_input(command, where, name="target", metavar="DIR-or-RECIPE-or-ROBOT")
    add_flags(command.add_argument_group("spawn"), spawn)
    add_target_recipe_flags(command, _OWN)


def run(arguments: argparse.Namespace) -> Report:
    """Spawn it, and give its name and pose."""
    from rsegen.exporters.gazebo.sdf import numbers
    from rsegen.simulation.simulators import SIMULATORS

    with flags_in_errors(spawn):
        target = target_of(arguments, _OWN)
    result = call(spawn, arguments, target)
    x, y, z, _, _, yaw = astuple(result.at)
    on_top = f"; put on top of it: {', '.join(result.put_on_top)}" if result.put_on_top else ""
    where = f"{SIMULATORS[result.simulator].title} at {numbers([x, y, z])}, turned by {numbers([yaw])} rad"
    on = f", on {result.on}" if result.on else ""
    lines = [f"{result.name} is in {where}{on}{on_top}", *(f"note: {in_flags(line, 'spawn')}" for line in result.notes)]
    return Report(lines=lines, content=asdict(result), notes=which_map(arguments.target, arguments.map))
