"""The commands that change a running simulation: spawn, respawn and remove."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import asdict, astuple, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from rsegen.cli.flags import add_input, add_target_recipe_flags, target_of, which_map
from rsegen.cli.parameters import MapReference
from rsegen.cli.parser import Parser
from rsegen.cli.report import Report, call
from rsegen.errors import ParameterError, shown
from rsegen.field.crossing import robot_kinds
from rsegen.params.command import Shell, add_flags, command, flags_in_errors
from rsegen.params.sorts import (
    FilePath,
    Float,
    Json,
    ListOf,
    Parameter,
    Text,
    parameters,
)
from rsegen.recipe.recipe import Run
from rsegen.robots.parameters import AnyRobot
from rsegen.simulators.parameters import RunningSimulator, Timeout

if TYPE_CHECKING:
    from rsegen.robots.base import Robot
    from rsegen.robots.files.sdf_file import SdfRobot
    from rsegen.spawning.spawning import RemoveResult, RespawnResult, SpawnResult
    from rsegen.writing.target_worlds import Target


ModelName = Annotated[
    str | None, Text(r"[^\x00-\x1f]{1,200}", "a name", help="name of the model"), Shell(metavar="NAME")
]


MapsFolder = Annotated[
    str | Path,
    FilePath(help="folder in which maps made from recipes are kept"),
    Shell(("-o", "--output"), "DIR"),
]


class SpawnPose(Parameter):
    """A pose on the ground: x and y, then perhaps z, then perhaps yaw, in metres and radians."""

    help = "pose in metres and radians, as in --at -2,0"
    _metres = Float(-1e6, 1e6)

    def check(self, where: str, value: object) -> tuple[float, ...]:
        if not isinstance(value, Sequence) or isinstance(value, str) or not 2 <= len(value) <= 4:
            raise ParameterError(where, f"{shown(value)} is not {self.describe()}")
        return tuple(self._metres.check(f"{where}[{axis}]", length) for axis, length in enumerate(value))

    def parse(self, text: str) -> object:
        parts = text.split(",")
        return [self._metres.parse(part) for part in parts] if 2 <= len(parts) <= 4 else text

    def format(self, value: Any) -> str:
        return ",".join(map(str, value))

    def schema(self) -> dict[str, Json]:
        return {"type": "array", "items": self._metres.schema(), "minItems": 2, "maxItems": 4}

    def describe(self) -> str:
        return "X,Y or X,Y,Z or X,Y,Z,YAW"


@command
def spawn(  # noqa: PLR0913  # each is a flag
    target: Target | Robot | SdfRobot,
    *,
    map: MapReference = None,  # noqa: A002  # the flag's name
    name: Annotated[
        str | None,
        replace(parameters(Run)["name"], help="name of the model"),
        Shell(metavar="NAME", default="the map's name, or the kind of robot"),
    ] = None,
    at: Annotated[
        Sequence[float] | None,
        SpawnPose(),
        Shell(
            metavar="X,Y[,Z[,YAW]]",
            default="for a robot, a spot of a spawned map; else the free place nearest to the origin",
        ),
    ] = None,
    robot: Annotated[
        AnyRobot,
        Shell(help="put this robot (a kind or a file) on the map, which is spawned first if necessary"),
    ] = None,
    pose: Annotated[
        Sequence[float] | None,
        ListOf(
            Float(-1e6, 1e6),
            3,
            help="pose of that robot: x and y [m] from the map's middle, yaw [rad]",
        ),
        Shell(metavar="X,Y,YAW", default="a spot of the map"),
    ] = None,
    output: MapsFolder = Path("worlds"),
    simulator: RunningSimulator = None,
    timeout: Timeout = 20.0,
) -> SpawnResult:
    """Spawn a map, a robot, or a robot on a map in the running simulation, and report its name and pose.

    With `robot` the name and the pose are its own; at a `pose` it is at rest as `rsegen.poses` has it, 5 mm higher.
    The simulation is the one at GAZEBO_MASTER_URI or in GZ_PARTITION if one of these variables is set, else the last
    one that `rsegen open` began and that still runs, else the one at a default address.

    Parameters
    ----------
    target : Recipe, Scene, str, path or robot
        The folder of a map or of maps, a recipe, a scene, a kind of robot, the file of one, or a robot.

    Returns
    -------
    SpawnResult
        Name and pose.

    Raises
    ------
    UserError
        If a value is wrong.
    NothingRuns
        If no simulation runs.
    """
    from rsegen.spawning.spawning import spawn_model

    return spawn_model(target, map, name, at, robot, pose, Path(output), simulator, timeout)


@command
def respawn(
    target: Target,
    *,
    map: Annotated[MapReference, Shell(metavar="INDEX", default="the next")] = None,  # noqa: A002  # the flag's name
    name: Annotated[ModelName, Shell(help="name of the model to replace, if there are several maps")] = None,
    output: MapsFolder = Path("worlds"),
    simulator: RunningSimulator = None,
    timeout: Timeout = 20.0,
) -> RespawnResult:
    """Replace the map of the running simulation by the next one of a recipe or folder, at the same pose.

    Robots and their programs keep running; models on the map are put on top of the new blocks in a paused world.

    Parameters
    ----------
    target : Recipe, Scene, str or path
        The recipe of the current map, or the folder of its maps; after the last map of a folder comes the first.

    Returns
    -------
    RespawnResult
        Names and pose.

    Raises
    ------
    UserError
        If a value is wrong, or no map is there.
    NothingRuns
        If no simulation runs.
    """
    from rsegen.spawning.spawning import replace_map

    return replace_map(target, map, name, Path(output), simulator, timeout)


@command
def remove(*names: str, simulator: RunningSimulator = None, timeout: Timeout = 20.0) -> RemoveResult:
    """Delete maps, robots and other models from the running simulation; none of them if one does not exist.

    Parameters
    ----------
    *names : str
        Names of the models.

    Returns
    -------
    RemoveResult
        What was deleted.

    Raises
    ------
    UnknownName
        If one does not exist; the error lists the models.
    """
    from rsegen.spawning.spawning import remove_models

    return remove_models(names, simulator, timeout)


_OWN_OF_SPAWN = ("simulator", "name")
"""Flags that say something else here than in a recipe."""


def add_spawn(command: Parser) -> None:
    """Add the flags of `rsegen spawn`."""
    epilog = (
        "rsegen open, in another shell, starts a simulation; one of another program is found by GAZEBO_MASTER_URI or "
        "GZ_PARTITION, or at the default addresses."
    )
    command.explain(spawn.__doc__, epilog, robot_kinds)
    where = "the folder of a map or of maps, a recipe, a kind of robot, or the SDF, URDF, Xacro or MJCF file of a robot"
    add_input(command, where, name="target", metavar="DIR-or-RECIPE-or-ROBOT")
    add_flags(command.group("spawn"), spawn)
    add_target_recipe_flags(command, _OWN_OF_SPAWN)


def run_spawn(arguments: argparse.Namespace) -> Report:
    """Spawn a map or a robot, and report its name and pose."""
    from rsegen.gazebo.sdf import numbers
    from rsegen.simulators.base import SIMULATORS

    with flags_in_errors(spawn):
        target = target_of(arguments, _OWN_OF_SPAWN)
    result = call(spawn, arguments, target)
    x, y, z, _, _, yaw = astuple(result.at)
    where = f"{SIMULATORS[result.simulator].title} at {numbers([x, y, z])}, turned by {numbers([yaw])} rad"
    on = f", on {result.on}" if result.on else ""
    lines = [f"{result.name} is in {where}{on}{_on_top(result)}"]
    lines += [f"note: {line}" for line in result.notes]
    return Report(lines=lines, content=asdict(result), notes=which_map(arguments.target, arguments.map))


def _on_top(result: SpawnResult | RespawnResult) -> str:
    return f"; put on top of it: {', '.join(result.put_on_top)}" if result.put_on_top else ""


def add_respawn(command: Parser) -> None:
    """Add the flags of `rsegen respawn`."""
    epilog = (
        "Robots and their programs keep running; models on the map are put on top of the new blocks in a paused world."
    )
    command.explain(respawn.__doc__, epilog)
    where = "the recipe of the current map, or the folder of its maps; after the last map of a folder comes the first"
    command.add_argument("target", metavar="RECIPE-or-DIR", help=where)
    add_flags(command.group("respawn"), respawn)


def run_respawn(arguments: argparse.Namespace) -> Report:
    """Replace the map, and report the names of both."""
    from rsegen.gazebo.sdf import numbers

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
    """Delete models, and report their names."""
    from rsegen.simulators.base import SIMULATORS

    result = call(remove, arguments, *arguments.names)
    removed = ", ".join(result.removed)
    return Report(lines=[f"{removed} removed from {SIMULATORS[result.simulator].title}"], content=asdict(result))
