"""rsegen drive: a robot over a map, in a real simulator."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, replace
from pathlib import Path, PurePosixPath
from typing import Any

from rsegen.cli.bar import watched
from rsegen.cli.flags import Subparsers
from rsegen.cli.worlds import World, world_of
from rsegen.errors import FileError, NoSimulator, ParameterError, shown
from rsegen.exporters.scene import Scene, compose
from rsegen.io.resources import refuse_too_large
from rsegen.io.writer import write
from rsegen.params.sorts import Choice, Float, Integer, ListOf, Parameter
from rsegen.params.streams import SEEDS, fresh_seed
from rsegen.recipe.codec import map_json
from rsegen.simulation.driving.contacts import contact_shares, csv
from rsegen.simulation.driving.drive import DriveResult, RobotRun, driven
from rsegen.simulation.driving.drive_metrics import DriveMetrics, drive_metrics
from rsegen.simulation.driving.robot_runs import ROUTES, driving_speed, finish_x, robot_runs
from rsegen.simulation.driving.trajectory_plot import draw_trajectories
from rsegen.simulation.robots import ROBOTS, robot
from rsegen.simulation.robots.base import DrivableRobot
from rsegen.simulation.robots.sdf_file import from_file
from rsegen.simulation.simulators import Installation
from rsegen.simulation.simulators.launching import choose_installation, has_screen

COUNT, SECONDS, SEED = Integer(1, 100), Float(0.1, 1e5, unit="s"), Integer(0, SEEDS - 1)
_SAID = 5
"""So many of its parts that touch most are told of a robot; drive.json has all."""

ROUTE = Choice(ROUTES)
OWN: Mapping[str, Parameter] = {
    "size": ListOf(Float(0.01, 100, unit="m"), 3),
    "speed": Float(0.001, 100, unit="m/s"),
    "turn": Float(0.001, 100, unit="rad/s"),
}
"""What a person says of the robot in a file."""


def add(commands: Subparsers) -> None:
    """The parser of this command."""
    command = commands.add_parser(
        "drive",
        help="drive a robot over a map in Gazebo, and tell how far it got",
        description="Drive robots over a map in a Gazebo server without a window, and tell how far each got. The same "
        "seed and simulator give the same tracks.",
        epilog="rsegen sim lists the simulators that are here. Kinds of robots: " + ", ".join(ROBOTS) + ".",
    )
    command.add_argument("target", metavar="WORLD-or-DIR-or-RECIPE", help="a world of rsegen, its folder, or a recipe")
    command.add_argument("--map", metavar="INDEX", help="which map, by its index or its name (default: the first)")
    command.add_argument(
        "--robot", default="burger", metavar="KIND|SDF", help="kind of robot, or the file of a model (default: burger)"
    )
    command.add_argument("--size", metavar="L,W,H", help="of the robot in the file, metres (default: 0.5,0.5,0.5)")
    command.add_argument("--speed", metavar="V", help="the most that it is told to go, m/s (default: 0.2)")
    command.add_argument("--turn", metavar="W", help="the most that it is told to turn, rad/s (default: 0.5)")
    command.add_argument(
        "--robots", default="1", metavar="N", help=f"how many of them ({COUNT.describe()}, default: 1)"
    )
    command.add_argument(
        "--route", default="straight", help=f"{ROUTE.describe()}: across the map, or about on top of it"
    )
    command.add_argument("--duration", default="30", metavar="S", help="simulated seconds (default: 30)")
    command.add_argument("--seed", metavar="SEED", help="of places and routes; drawn and told where none is given")
    command.add_argument(
        "-o", "--output", type=Path, metavar="DIR", help="write tracks, measures and a picture into it"
    )
    command.add_argument(
        "--picture",
        action="store_true",
        help="add gazebo.jpg to DIR: what Gazebo's own camera saw last; needs a screen",
    )
    command.add_argument("--force", action="store_true", help="replace DIR")
    command.add_argument("--json", action="store_true", help="print the measures for programs")
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Drive, and say what came of it."""
    kind, seed = _robot(arguments), _seed(arguments.seed)
    count = COUNT.check("--robots", COUNT.parse(arguments.robots))
    seconds = SECONDS.check("--duration", SECONDS.parse(arguments.duration))
    route = ROUTE.check("--route", arguments.route)
    _check_picture(arguments)
    world = world_of(arguments.target, arguments.map)
    here, scene = choose_installation(world.made_for, "classic"), _scene(world, arguments.target)
    runs = robot_runs(scene.field, kind, route, count=count, seed=seed)
    with world.on_disk() as file, _bar(seconds) as progress:
        watched = scene.field.extent if arguments.picture else None
        drive = driven(here, file, runs, seconds, progress, watched=watched)
    goal = finish_x(scene.field, kind) if route == "straight" else None
    trips = {
        name: drive_metrics(trajectory, driving_speed(kind), goal, contact_shares(drive.samples, name))
        for name, trajectory in drive.trajectories.items()
    }
    told = _summary(here, scene, route, seed, runs, trips) | {"errors": list(drive.errors)}
    if arguments.output:
        write(_files(scene, drive, told), arguments.output, force=arguments.force)
    print(json.dumps(told, indent=2) if arguments.json else "\n".join(_report(told, trips)))


def _robot(arguments: argparse.Namespace) -> DrivableRobot:
    """One of ours, or that of a file; only of such a one does a person say what it is like."""
    said = {name: getattr(arguments, name) for name in OWN if getattr(arguments, name) is not None}
    if arguments.robot.endswith(".sdf"):
        values = {name: OWN[name].check(f"--{name}", OWN[name].parse(text)) for name, text in said.items()}
        return replace(from_file(arguments.robot), **values)
    for name in said:
        raise ParameterError(f"--{name}", f"is for the robot of a file; {shown(arguments.robot)} has its own")
    return robot(arguments.robot, "--robot")


def _check_picture(arguments: argparse.Namespace) -> None:
    if arguments.picture and not arguments.output:
        raise ParameterError("--picture", "needs a folder to be written into; give -o DIR")
    if arguments.picture and not has_screen():
        raise NoSimulator(
            "--picture: Gazebo draws on a screen, and there is none here; put xvfb-run -a before the command"
        )


def _seed(text: str | None) -> int:
    return fresh_seed() if text is None else SEED.check("--seed", SEED.parse(text))


def _scene(world: World, target: str) -> Scene:
    if not world.recipe:
        raise FileError(f"{target}: no recipe.json beside it, so nobody knows where its blocks are")
    refuse_too_large(world.recipe)
    return compose(world.recipe, world.recipe.first_map)


def _summary(
    here: Installation, scene: Scene, route: str, seed: int, runs: Sequence[RobotRun], trips: Mapping[str, DriveMetrics]
) -> dict[str, object]:
    robots = [
        {"name": run.name, "kind": run.robot.kind, "start": asdict(run.start), **asdict(trips[run.name])}
        for run in runs
    ]
    return {"map": scene.name, "simulator": str(here), "route": route, "seed": seed, "robots": robots}


def _files(scene: Scene, drive: DriveResult, told: Mapping[str, object]) -> dict[PurePosixPath, list[bytes]]:
    trajectories = {
        PurePosixPath(f"{name}.csv"): [row.encode() for row in trajectory.csv()]
        for name, trajectory in drive.trajectories.items()
    }
    return {
        **trajectories,
        PurePosixPath("contacts.csv"): [row.encode() for row in csv(drive.samples, drive.trajectories)],
        PurePosixPath("recipe.json"): [map_json(scene.recipe, scene.index)],
        PurePosixPath("drive.json"): [json.dumps(told, indent=2).encode() + b"\n"],
        PurePosixPath("drive.png"): [draw_trajectories(scene, drive.trajectories)],
    } | ({PurePosixPath("gazebo.jpg"): [drive.seen]} if drive.seen else {})


def _report(told: Mapping[str, Any], trips: Mapping[str, DriveMetrics]) -> Iterator[str]:
    yield f"{told['map']} in {told['simulator']}, {told['route']}, seed {told['seed']}:"
    for name, found in trips.items():
        crossed = "" if told["route"] != "straight" else _crossed(found)
        tipped = f", tipped over {found.tipped}x" if found.tipped else ""
        yield f"  {name}: {found.distance:.2f} m in {found.seconds:g} s{crossed}, stuck {found.stuck:g} s{tipped}"
        if found.touched:
            yield "    touching with " + ", ".join(f"{part} {share:.0%}" for part, share in _most(found.touched))
    yield from (f"warning: {line}" for line in dict.fromkeys(told["errors"]))


def _most(touched: Mapping[str, float]) -> Sequence[tuple[str, float]]:
    return list(touched.items())[:_SAID]


def _crossed(found: DriveMetrics) -> str:
    return f", crossed the map after {found.crossed:g} s" if found.crossed is not None else ", did not cross the map"


@contextmanager
def _bar(seconds: float) -> Iterator[Callable[[float], None]]:
    """A progress bar on a terminal."""
    if not watched():
        yield lambda _: None
        return
    from tqdm import tqdm

    with tqdm(total=seconds, unit="s", bar_format="{l_bar}{bar}| {n:.0f}/{total:.0f} simulated s [{elapsed}]") as bar:

        def progress(done: float) -> None:
            bar.update(done - bar.n)

        yield progress
