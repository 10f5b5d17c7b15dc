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
from rsegen.simulation.driving.contacts import csv, shares
from rsegen.simulation.driving.drive import Drive, Driver, driven
from rsegen.simulation.driving.drive_metrics import Trip, measured
from rsegen.simulation.driving.runs import ROUTES, beyond, crew, easy
from rsegen.simulation.driving.trajectory_plot import sketch
from rsegen.simulation.robots import ROBOTS, robot
from rsegen.simulation.robots.base import Driven
from rsegen.simulation.robots.own import from_file
from rsegen.simulation.simulators import Installation
from rsegen.simulation.simulators.opening import fitting, has_screen

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
    here, scene = fitting(world.made_for, "classic"), _scene(world, arguments.target)
    drivers = crew(scene.field, kind, route, count=count, seed=seed)
    with world.on_disk() as file, _bar(seconds) as progress:
        watched = scene.field.extent if arguments.picture else None
        drive = driven(here, file, drivers, seconds, progress, watched=watched)
    goal = beyond(scene.field, kind) if route == "straight" else None
    trips = {name: measured(track, easy(kind), goal, shares(drive.looks, name)) for name, track in drive.tracks.items()}
    told = _summary(here, scene, route, seed, drivers, trips) | {"errors": list(drive.errors)}
    if arguments.output:
        write(_files(scene, drive, told), arguments.output, force=arguments.force)
    print(json.dumps(told, indent=2) if arguments.json else "\n".join(_report(told, trips)))


def _robot(arguments: argparse.Namespace) -> Driven:
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
    here: Installation, scene: Scene, route: str, seed: int, drivers: Sequence[Driver], trips: Mapping[str, Trip]
) -> dict[str, object]:
    robots = [
        {"name": driver.name, "kind": driver.robot.kind, "start": asdict(driver.start), **asdict(trips[driver.name])}
        for driver in drivers
    ]
    return {"map": scene.name, "simulator": str(here), "route": route, "seed": seed, "robots": robots}


def _files(scene: Scene, drive: Drive, told: Mapping[str, object]) -> dict[PurePosixPath, list[bytes]]:
    tracks = {
        PurePosixPath(f"{name}.csv"): [row.encode() for row in track.csv()] for name, track in drive.tracks.items()
    }
    return {
        **tracks,
        PurePosixPath("contacts.csv"): [row.encode() for row in csv(drive.looks, drive.tracks)],
        PurePosixPath("recipe.json"): [map_json(scene.recipe, scene.index)],
        PurePosixPath("drive.json"): [json.dumps(told, indent=2).encode() + b"\n"],
        PurePosixPath("drive.png"): [sketch(scene, drive.tracks)],
    } | ({PurePosixPath("gazebo.jpg"): [drive.seen]} if drive.seen else {})


def _report(told: Mapping[str, Any], trips: Mapping[str, Trip]) -> Iterator[str]:
    yield f"{told['map']} in {told['simulator']}, {told['route']}, seed {told['seed']}:"
    for name, trip in trips.items():
        crossed = "" if told["route"] != "straight" else _crossed(trip)
        tipped = f", tipped over {trip.tipped}x" if trip.tipped else ""
        yield f"  {name}: {trip.distance:.2f} m in {trip.seconds:g} s{crossed}, stuck {trip.stuck:g} s{tipped}"
        if trip.touched:
            yield "    touching with " + ", ".join(f"{part} {share:.0%}" for part, share in _most(trip.touched))
    yield from (f"warning: {line}" for line in dict.fromkeys(told["errors"]))


def _most(touched: Mapping[str, float]) -> Sequence[tuple[str, float]]:
    return list(touched.items())[:_SAID]


def _crossed(trip: Trip) -> str:
    return f", crossed the map after {trip.crossed:g} s" if trip.crossed is not None else ", did not cross the map"


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
