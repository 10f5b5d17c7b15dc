"""rsegen drive: robots driven over a map in Gazebo, and how far each got."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rsegen.cli.bar import watched
from rsegen.cli.flags import Subparsers, add_force_flag, add_target_recipe_flags
from rsegen.cli.simulation_flags import flags_in_errors, simulator_names
from rsegen.cli.targets import target_of
from rsegen.params.sorts import Parameter
from rsegen.robots import ROBOTS as KINDS
from rsegen.robots.base import LIMITS
from rsegen.simulation.driving.drive import DURATION, ROBOTS, ROUTE, SEED, drive

_NUMBERS: Mapping[str, Parameter] = {"robots": ROBOTS, "duration": DURATION, "seed": SEED, **LIMITS}

_OWN = ("simulator",)
"""Flags that say something else here than in a recipe."""


def add(commands: Subparsers) -> None:
    """Add the parser of this command."""
    command = commands.add_parser(
        "drive",
        description="Drive robots over a map in a Gazebo server without a window, and report how far each got. The "
        "same seed and simulator give the same trajectories.",
        epilog="rsegen sim lists the installed simulators. Kinds of robots: " + ", ".join(KINDS) + ".",
    )
    where = "a world made by rsegen, its folder, or a recipe"
    command.add_argument("target", nargs="?", metavar="WORLD-or-DIR-or-RECIPE", help=where)
    command.add_argument("--map", metavar="INDEX", help="map, by its index or name (default: the first)")
    command.add_argument(
        "--robot", default="burger", metavar="KIND|SDF", help="kind of robot, or SDF file of a model (default: burger)"
    )
    text = "joints of its wheels, as LEFT,RIGHT or FRONT+REAR,FRONT+REAR (default: from its drive plug-in)"
    command.add_argument("--wheels", metavar="LEFT,RIGHT", help=text)
    text = "size of the robot in the file, m (default: of its collision shapes)"
    command.add_argument("--size", metavar="L,W,H", help=text)
    text = "its maximum commanded speed, m/s (default: of its plug-in or joints, else 0.2)"
    command.add_argument("--speed", metavar="V", help=text)
    text = "its maximum commanded turn rate, rad/s (default: of its plug-in, else 0.5)"
    command.add_argument("--turn", metavar="W", help=text)
    command.add_argument(
        "--robots", default="1", metavar="N", help=f"number of robots ({ROBOTS.describe()}, default: 1)"
    )
    text = f"{simulator_names()} (default: the newest that is installed)"
    command.add_argument("--simulator", metavar="NAME", help=text)
    text = "straight across the map, randomly on it, or across it on the path that rsegen metrics finds"
    command.add_argument("--route", default="straight", help=f"{ROUTE.describe()}: {text} (default: straight)")
    command.add_argument("--duration", default="30", metavar="S", help="simulation time, seconds (default: 30)")
    text = "seed of start poses and routes, and of a map made by --obstacle alone (default: drawn and printed)"
    command.add_argument("--seed", metavar="SEED", help=text)
    text = "do not record contacts, which take Gazebo Sim 1.5 to 1.8 times the CPU time"
    command.add_argument("--no-contacts", dest="contacts", action="store_false", help=text)
    command.add_argument("-o", "--output", type=Path, metavar="DIR", help="write trajectories, metrics and a picture")
    command.add_argument(
        "--picture", action="store_true", help="add gazebo.jpg to DIR, from a camera in Gazebo; needs a screen"
    )
    add_force_flag(command, "an earlier drive in DIR")
    command.add_argument("--json", action="store_true", help="print the metrics as JSON")
    add_target_recipe_flags(command, ("seed", *_OWN))
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Drive, and print the metrics."""
    given = {name: getattr(arguments, name) for name in _NUMBERS}
    with flags_in_errors(*_NUMBERS, "map", "robot", "wheels", "route", "picture", "simulator"):
        numbers: dict[str, Any] = {
            name: _NUMBERS[name].check(name, _NUMBERS[name].parse(text))
            for name, text in given.items()
            if text is not None
        }
        target = target_of(arguments, _OWN if arguments.target is None else ("seed", *_OWN))
        with _bar(numbers["duration"]) as progress:
            result = drive(
                target,
                map=arguments.map,
                robot=arguments.robot,
                wheels=arguments.wheels,
                simulator=arguments.simulator,
                route=arguments.route,
                contacts=arguments.contacts,
                output=arguments.output,
                picture=arguments.picture,
                force=arguments.force,
                progress=progress,
                **numbers,
            )
    print(json.dumps(result.as_json(), indent=2) if arguments.json else "\n".join(result.report()))


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
