"""The commands of simulators: open, drive, spawn, respawn, remove and experiment."""

from __future__ import annotations

import argparse
import json
import shlex
import sys
from dataclasses import asdict, astuple
from itertools import chain
from typing import TYPE_CHECKING

from rsegen.cli.commands import Parser
from rsegen.cli.edge import how_to_go_on, in_flags
from rsegen.cli.flags import add_input, add_target_recipe_flags, target_of, which_map
from rsegen.cli.report import Report, call, checked_flags, robot_kinds, seconds_bar, trials_bar
from rsegen.commands.simulation import drive, experiment, remove, respawn, spawn
from rsegen.commands.simulation import open as open_world
from rsegen.errors import printable
from rsegen.params.command import add_flags, default, flags_in_errors, given

if TYPE_CHECKING:
    from rsegen.simulation.open_world import OpenedWorld
    from rsegen.simulation.spawning import RespawnResult, SpawnResult

_OWN = ("simulator",)
_OWN_OF_SPAWN = ("simulator", "name")
"""Flags that say something else here than in a recipe."""

_WORLD = "WORLD-or-DIR-or-RECIPE"


def add_open(command: Parser) -> None:
    """Add the flags of `rsegen open`."""
    epilog = "rsegen sim lists the installed simulators. Error lines of the simulator go to stderr."
    command.explain(open_world.__doc__, epilog)
    where = "a world file, the folder of a map or of maps, or a recipe (a temporary world is made)"
    add_input(command, where, name="target", metavar=_WORLD)
    group = command.add_argument_group("open")
    add_flags(group, open_world)
    group.add_argument("--print", action="store_true", help="print the shell command and open nothing")
    add_target_recipe_flags(command, _OWN)


def run_open(arguments: argparse.Namespace) -> Report:
    """Open a world, and wait until it ends."""
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
            line = f"{world.simulator}: {world.file}" + (f", at {address}" if address else "")
            print(line, *which_map(arguments.target, arguments.map), sep="\n", flush=True)

    def failed(line: str) -> None:
        print(printable(line), file=sys.stderr, flush=True)

    result = call(open_world, arguments, target, on_start=started, on_error=failed)
    opened = {"simulator": result.world.simulator, "world": str(result.world.file)}
    ended = {"address": dict(result.world.address), "exit_code": result.exit_code, "errors": list(result.errors)}
    return Report(lines=[], content=opened | ended)


def add_drive(command: Parser) -> None:
    """Add the flags of `rsegen drive`."""
    epilog = (
        "The burger, which drives by default, gets over no frame; the crawler does; --boundary none leaves them out. "
        "rsegen sim lists the installed simulators. With --obstacle alone, --seed is also that of the map. "
    )
    command.explain(drive.__doc__, epilog + robot_kinds())
    add_input(command, "a world made by rsegen, its folder, or a recipe", name="target", metavar=_WORLD)
    add_flags(command.add_argument_group("drive"), drive)
    add_target_recipe_flags(command, ("seed", *_OWN))


def run_drive(arguments: argparse.Namespace) -> Report:
    """Drive, and report the metrics."""
    with flags_in_errors(drive):
        target = target_of(arguments, _OWN if arguments.target is None else ("seed", *_OWN))
    said = checked_flags(drive, arguments)
    with seconds_bar(said.get("duration", default(drive, "duration"))) as progress:
        result = call(drive, arguments, target, progress=progress)
    played = [f"to see it drive: rsegen gui {shlex.quote(str(said['output']))}"] if "output" in said else []
    notes = which_map(arguments.target, arguments.map)
    return Report(lines=chain(result.report(), played), content=result.as_json, notes=notes)


def add_spawn(command: Parser) -> None:
    """Add the flags of `rsegen spawn`."""
    epilog = (
        "Gazebo Classic is looked for at GAZEBO_MASTER_URI, Gazebo Sim in GZ_PARTITION, or at their default addresses. "
        "rsegen open --shared starts a simulation. "
    )
    command.explain(spawn.__doc__, epilog + robot_kinds())
    where = "the folder of a map or of maps, a recipe, a kind of robot, or the SDF, URDF or Xacro file of a robot"
    add_input(command, where, name="target", metavar="DIR-or-RECIPE-or-ROBOT")
    add_flags(command.add_argument_group("spawn"), spawn)
    add_target_recipe_flags(command, _OWN_OF_SPAWN)


def run_spawn(arguments: argparse.Namespace) -> Report:
    """Spawn a map or a robot, and give its name and pose."""
    from rsegen.exporters.gazebo.sdf import numbers
    from rsegen.simulation.simulators import SIMULATORS

    with flags_in_errors(spawn):
        target = target_of(arguments, _OWN_OF_SPAWN)
    result = call(spawn, arguments, target)
    x, y, z, _, _, yaw = astuple(result.at)
    where = f"{SIMULATORS[result.simulator].title} at {numbers([x, y, z])}, turned by {numbers([yaw])} rad"
    on = f", on {result.on}" if result.on else ""
    lines = [f"{result.name} is in {where}{on}{_on_top(result)}"]
    lines += [f"note: {in_flags(line, 'spawn')}" for line in result.notes]
    return Report(lines=lines, content=asdict(result), notes=which_map(arguments.target, arguments.map))


def _on_top(result: SpawnResult | RespawnResult) -> str:
    return f"; put on top of it: {', '.join(result.put_on_top)}" if result.put_on_top else ""


def add_respawn(command: Parser) -> None:
    """Add the flags of `rsegen respawn`."""
    epilog = (
        "Robots and their programs go on; models on the map are put on top of the new blocks while the world is paused."
    )
    command.explain(respawn.__doc__, epilog)
    where = "the recipe of the current map, or the folder of its maps; after the last map of a folder comes the first"
    command.add_argument("target", metavar="RECIPE-or-DIR", help=where)
    add_flags(command.add_argument_group("respawn"), respawn)


def run_respawn(arguments: argparse.Namespace) -> Report:
    """Replace the map, and give the names of both."""
    from rsegen.exporters.gazebo.sdf import numbers

    result = call(respawn, arguments, arguments.target)
    at = numbers([result.at.x, result.at.y, result.at.z])
    line = f"{result.name} replaces {result.instead_of}, at {at}{_on_top(result)}"
    return Report(lines=[line], content=asdict(result))


def add_remove(command: Parser) -> None:
    """Add the flags of `rsegen remove`."""
    command.explain(remove.__doc__)
    command.add_argument("names", nargs="+", metavar="NAME", help="name of a model in the simulation")
    add_flags(command, remove)


def run_remove(arguments: argparse.Namespace) -> Report:
    """Delete models, and give their names."""
    from rsegen.simulation.simulators import SIMULATORS

    result = call(remove, arguments, *arguments.names)
    removed = ", ".join(result.removed)
    return Report(lines=[f"{removed} removed from {SIMULATORS[result.simulator].title}"], content=asdict(result))


def add_experiment(command: Parser) -> None:
    """Add the flags of `rsegen experiment`."""
    epilog = (
        "The folder gets table.md, trials.csv, summary.json, plot.png, and the trajectories in tracks. "
        "The same command continues a stopped experiment."
    )
    command.explain(experiment.__doc__, epilog)
    names = "quick, driven, paper, burgers, frames, representations"
    command.add_argument("plan", metavar="PLAN", help=f"{names}, or a YAML file like these")
    add_flags(command.add_argument_group("output"), experiment)


def run_experiment(arguments: argparse.Namespace) -> Report:
    """Run all trials, and give the table."""
    from rsegen.simulation.experiment.plan import load_plan
    from rsegen.simulation.experiment.run import in_simulators

    with flags_in_errors(experiment):
        plan = in_simulators(load_plan(arguments.plan), given(experiment, arguments).get("simulator"))
    with how_to_go_on(), trials_bar(plan) as progress:
        result = call(experiment, arguments, arguments.plan, progress=progress)
    return Report(lines=[result.table], content=lambda: json.loads((result.folder / "summary.json").read_text("utf-8")))
