"""`rsegen spawn`, `respawn`, `remove`: what changes a running simulation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from rsegen.commands.parameters import AnyRobot, MapReference, MapsFolder, ModelName, RunningSimulator, Timeout
from rsegen.errors import ParameterError, shown
from rsegen.params.command import Shell, command
from rsegen.params.sorts import Float, Json, ListOf, parameters
from rsegen.recipe.recipe import Run

if TYPE_CHECKING:
    from rsegen.robots import Robot, SdfRobot
    from rsegen.simulation.spawning.spawn import RemoveResult, RespawnResult, SpawnResult
    from rsegen.simulation.worlds import Target


class Place:
    """A pose on the ground: x and y, then perhaps z, then perhaps yaw, in metres and radians."""

    help = "pose in metres and radians, as in --at=-2,0"
    _metres = Float(-1e6, 1e6)

    def check(self, where: str, value: object) -> tuple[float, ...]:
        """Return two to four numbers, or raise a ParameterError."""
        if not isinstance(value, Sequence) or isinstance(value, str) or not 2 <= len(value) <= 4:
            raise ParameterError(where, f"{shown(value)} is not {self.describe()}")
        return tuple(self._metres.check(f"{where}[{axis}]", length) for axis, length in enumerate(value))

    def parse(self, text: str) -> object:
        """Return the numbers of a text, or the text if they are not two to four."""
        parts = text.split(",")
        return [self._metres.parse(part) for part in parts] if 2 <= len(parts) <= 4 else text

    def format(self, value: Any) -> str:
        """Return the numbers separated by commas."""
        return ",".join(map(str, value))

    def schema(self) -> dict[str, Json]:
        """Return the JSON Schema of a list of two to four numbers."""
        return {"type": "array", "items": self._metres.schema(), "minItems": 2, "maxItems": 4}

    def describe(self) -> str:
        """Return what may be given."""
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
        Place(),
        Shell(
            metavar="X,Y[,Z[,YAW]]",
            default="for a robot a spot of a map that is there, else the free place nearest to the origin",
        ),
    ] = None,
    robot: Annotated[
        AnyRobot,
        Shell(help="put this robot on the map, which is spawned first if it is not there: its kind, or a file of it"),
    ] = None,
    pose: Annotated[
        Sequence[float] | None,
        ListOf(
            Float(-1e6, 1e6),
            3,
            help="where that robot is put down, at rest: x and y [m] from the map's middle, yaw [rad]",
        ),
        Shell(metavar="X,Y,YAW", default="a spot of the map"),
    ] = None,
    output: MapsFolder = Path("worlds"),
    simulator: RunningSimulator = None,
    timeout: Timeout = 20.0,
) -> SpawnResult:
    """Spawn a map, a robot, or a robot on a map in the running simulation, and give its name and pose there.

    target: the folder of a map or of maps, a recipe, a scene, a kind of robot, the file of one, or a robot. With
    `robot` the name and the pose are its own; at a `pose` it is at rest as `rsegen.poses` has it, 5 mm higher. Gazebo
    Classic is looked for at GAZEBO_MASTER_URI, Gazebo Sim in GZ_PARTITION, or at their default addresses. UserError if
    a value is wrong; NothingRuns if no simulation runs.
    """
    from rsegen.simulation.spawning.spawn import spawn_model

    return spawn_model(target, map, name, at, robot, pose, Path(output), simulator, timeout)


@command
def respawn(
    target: Target,
    *,
    map: Annotated[MapReference, Shell(metavar="INDEX", default="the next")] = None,  # noqa: A002  # the flag's name
    name: Annotated[ModelName, Shell(help="name of the model to replace, if several could be meant")] = None,
    output: MapsFolder = Path("worlds"),
    simulator: RunningSimulator = None,
    timeout: Timeout = 20.0,
) -> RespawnResult:
    """Replace the map of the running simulation by the next one of a recipe or folder, at the same pose.

    target: the recipe of the current map, or the folder of its maps; after the last map of a folder comes the first.
    Robots and their programs go on; models on the map are put on top of the new blocks while the world is paused.
    """
    from rsegen.simulation.spawning.spawn import replace_map

    return replace_map(target, map, name, Path(output), simulator, timeout)


@command
def remove(*names: str, simulator: RunningSimulator = None, timeout: Timeout = 20.0) -> RemoveResult:
    """Delete maps, robots and other models from the running simulation; none of them if one does not exist.

    UnknownName lists the models if one does not exist.
    """
    from rsegen.simulation.spawning.spawn import remove_models

    return remove_models(names, simulator, timeout)
