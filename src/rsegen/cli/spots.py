"""rsegen spots: even places on a map, for a start or a goal of a robot."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from math import degrees
from typing import Any

from rsegen.cli.flags import Subparsers, add_force_flag, add_target_recipe_flags
from rsegen.cli.picture_path import picture_path
from rsegen.cli.simulation_flags import flags_in_errors
from rsegen.cli.targets import add_target_flags, target_of
from rsegen.exporters.pictures.preview import image_format
from rsegen.exporters.pictures.robot_plots import spots_plot
from rsegen.footprints import Spot
from rsegen.params.sorts import Parameter
from rsegen.params.streams import fresh_seed
from rsegen.robots import ROBOTS
from rsegen.run.store import write_file
from rsegen.simulation.driving.spots import COUNT, MAX_DIFFERENCE, SEED, SIZE, spot_footprint, spots
from rsegen.simulation.worlds import world_of

_SORTS: Mapping[str, Parameter] = {"count": COUNT, "size": SIZE, "max_difference_cm": MAX_DIFFERENCE, "seed": SEED}


def add(commands: Subparsers) -> None:
    """Add the parser of this command."""
    command = commands.add_parser(
        "spots",
        description="Print even places on a map, for a start or a goal: a robot stands level there, within 3 degrees, "
        "and nothing but its wheels or tracks touches a block. rsegen drive --route random with the same seed starts "
        "there.",
        epilog="Kinds of robots: " + ", ".join(ROBOTS) + ".",
    )
    add_target_flags(command)
    group = command.add_argument_group("spots")
    text = "kind of robot, or SDF file of a model (default: burger)"
    group.add_argument("--robot", default="burger", metavar="KIND|SDF", help=text)
    text = "length and width of a robot in metres, in place of --robot"
    group.add_argument("--size", metavar="L,W", help=text)
    group.add_argument("--count", default="1", metavar="N", help=f"number of spots ({COUNT.describe()}, default: 1)")
    text = "largest height difference under the whole robot, cm (default: any; lower blocks under the body are allowed)"
    group.add_argument("--max-difference-cm", "--max-difference", metavar="CM", help=text)
    text = "seed of the choice, and of a map made by --obstacle alone (default: drawn and printed)"
    group.add_argument("--seed", metavar="SEED", help=text)
    output = command.add_argument_group("output")
    output.add_argument("--json", action="store_true", help="print a list as JSON, in metres and radians")
    text = "draw the footprints on the plan: png, svg, pdf, jpg or webp, by its ending"
    output.add_argument("-o", "--output", metavar="PICTURE", help=text)
    add_force_flag(output, "an existing picture")
    add_target_recipe_flags(command, ("seed",))
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Find, draw and print them."""
    path = picture_path(arguments.output, force=arguments.force)
    with flags_in_errors(*_SORTS, "map", "robot"):
        given: dict[str, Any] = {
            name: sort.check(name, sort.parse(text))
            for name, sort in _SORTS.items()
            if (text := getattr(arguments, name)) is not None
        }
        given.setdefault("seed", fresh_seed())
        target = target_of(arguments, () if arguments.target is None else ("seed",))
        scene = world_of(target, arguments.map).scene()
        found = spots(scene, robot=arguments.robot, **given)
        if path:
            outline = spot_footprint(arguments.robot, given.get("size"), None).outline
            write_file([spots_plot(scene, outline, found, image_format(path))], path, force=arguments.force)
    if arguments.json:
        content = {"map": scene.name, "seed": given["seed"], "spots": [asdict(spot) for spot in found]}
        print(json.dumps(content, indent=2))
        return
    print(f"{scene.name}, seed {given['seed']}:")
    print("\n".join(_rows(found)))


def _rows(found: Sequence[Spot]) -> Iterator[str]:
    yield "spot    x [m]    y [m]    z [m]  yaw [deg]  difference [cm]"
    for number, spot in enumerate(found):
        place = "".join(f"{value:9.3f}" for value in (spot.x, spot.y, spot.z))
        yield f"{number:>4}{place}{degrees(spot.yaw):11.1f}{100 * spot.difference:17.2f}"
