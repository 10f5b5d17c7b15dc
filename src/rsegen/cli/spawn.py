"""rsegen spawn: a map or a robot, put into the simulation that runs."""

from __future__ import annotations

import argparse
import json
import os.path
from collections.abc import Mapping
from dataclasses import asdict, astuple, replace
from pathlib import Path

from rsegen.cli.flags import Subparsers
from rsegen.cli.maps import add_output_flag, add_running_flags, map_of
from rsegen.errors import ParameterError, UnknownName, shown
from rsegen.exporters.gazebo.sdf import numbers
from rsegen.params.sorts import Float, parameters
from rsegen.recipe.examples import EXAMPLES
from rsegen.recipe.recipe import Recipe
from rsegen.simulation.driving.start_poses import DROP_HEIGHT
from rsegen.simulation.robots import ROBOTS, Robot
from rsegen.simulation.simulators import Simulator
from rsegen.simulation.simulators.connecting import connected
from rsegen.simulation.simulators.live_world import LiveWorld, Pose
from rsegen.simulation.spawning.map_models import MapModel, known
from rsegen.simulation.spawning.placement import free_rectangle
from rsegen.simulation.spawning.spawned_map import SpawnedMap
from rsegen.simulation.spawning.spawning import at_free_place, model_radius, occupied, put

METRES = Float(-1e6, 1e6)


def add(commands: Subparsers) -> None:
    """The parser of this command."""
    command = commands.add_parser(
        "spawn",
        help="spawn a map or a robot in the running simulation",
        description="Put a map or a robot into the simulation that runs: Gazebo Classic's at GAZEBO_MASTER_URI, or "
        "Gazebo Sim's in GZ_PARTITION, or at their usual addresses.",
        epilog="Kinds of robots: " + ", ".join(ROBOTS) + ". rsegen open --shared starts a simulation.",
    )
    where = "the folder of a map or of maps, a recipe, or a kind of robot"
    command.add_argument("target", metavar="DIR-or-RECIPE-or-ROBOT", help=where)
    command.add_argument("--map", metavar="INDEX", help="which map, by its index or its name (default: the first)")
    command.add_argument("--name", help="what it is called there (default: the map's name, or the kind of robot)")
    place = "where, metres and radians, as in --at=-2,0 (default: the free place that is nearest to the origin)"
    command.add_argument("--at", metavar="X,Y[,Z[,YAW]]", help=place)
    add_output_flag(command)
    add_running_flags(command)
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Put it there, and say where."""
    at = _numbers(arguments.at) if arguments.at is not None else None
    what = _robot_or_map(arguments)
    name = _name(arguments.name, what)
    with connected(arguments.simulator) as (simulator, live):
        poses = live.poses()
        if name in poses:
            raise ParameterError("--name", f"{shown(name)} is there already; give another, or rsegen remove {name}")
        homes = [arguments.output, *([what.folder.parent] if isinstance(what, MapModel) else [])]
        maps = known(poses, homes)
        if isinstance(what, MapModel):
            what.check_fits(simulator)
            done = _put_map(live, what, name, poses, maps, at)
        else:
            done = _put_robot(live, what, name, poses, maps, at)
    print(json.dumps(_summary(simulator, done), indent=2) if arguments.json else _line(simulator, done))


Done = tuple[str, Pose, list[str]]
"""Name and place of what was put in, and the names of what was put on top of it."""


def _put_map(
    live: LiveWorld, one: MapModel, name: str, poses: Mapping[str, Pose], maps: list[SpawnedMap], at: list[float] | None
) -> Done:
    new = SpawnedMap(name=name, field=one.field, at=Pose(x=0, y=0, z=0))
    new = at_free_place(new, poses, maps) if at is None else replace(new, at=_pose(at))
    return name, new.at, put(live, one.model(name), new)


def _put_robot(
    live: LiveWorld, robot: Robot, name: str, poses: Mapping[str, Pose], maps: list[SpawnedMap], at: list[float] | None
) -> Done:
    reach = model_radius(robot.kind)
    x, y = at[:2] if at else free_rectangle(reach, reach, occupied(poses, maps))[:2]
    ground = max((each.top(Pose(x=x, y=y, z=0), reach) for each in maps), default=0.0)
    pose = _pose([x, y, ground + DROP_HEIGHT] if not at or len(at) == 2 else at)
    live.spawn(robot.file(name, live.backend), pose)
    return name, pose, []


def _robot_or_map(arguments: argparse.Namespace) -> Robot | MapModel:
    target = arguments.target
    if target in ROBOTS:
        if arguments.map is not None:
            raise ParameterError("--map", f"{target} is a robot, and has no maps")
        return ROBOTS[target]
    bare = not (os.path.exists(target) or Path(target).suffix or os.sep in target or "#" in target)
    if bare and target not in EXAMPLES:
        raise UnknownName.among("", "folder, recipe, example or robot", target, [*ROBOTS, *EXAMPLES])
    return map_of(target, arguments.map, arguments.output)


def _name(given: str | None, what: Robot | MapModel) -> str:
    if given is None:
        return what.kind if isinstance(what, Robot) else what.name
    return str(parameters(Recipe)["name"].check("--name", given))


def _numbers(text: str) -> list[float]:
    parts = text.split(",")
    if not 2 <= len(parts) <= 4:
        raise ParameterError("--at", f"{shown(text)} is not X,Y or X,Y,Z or X,Y,Z,YAW")
    return [float(METRES.check("--at", METRES.parse(part))) for part in parts]


def _pose(at: list[float]) -> Pose:
    return Pose(x=at[0], y=at[1], z=at[2] if len(at) > 2 else 0.0, yaw=at[3] if len(at) > 3 else 0.0)


def _summary(simulator: Simulator, done: Done) -> dict[str, object]:
    name, pose, moved = done
    return {"name": name, "simulator": simulator.name, "at": asdict(pose), "put_on_top": moved}


def _line(simulator: Simulator, done: Done) -> str:
    name, pose, moved = done
    x, y, z, _, _, yaw = astuple(pose)
    poses_on_map = f"; put on top of it: {', '.join(moved)}" if moved else ""
    return f"{name} is in {simulator.title} at {numbers([x, y, z])}, turned by {numbers([yaw])} rad{poses_on_map}"
