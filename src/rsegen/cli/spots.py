"""rsegen spots: places on a map for a start or a goal of a robot."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from math import degrees
from typing import TYPE_CHECKING, Annotated

from rsegen.cli.flags import add_target_recipe_flags
from rsegen.cli.parser import Parser
from rsegen.cli.report import Report, robot_kinds
from rsegen.cli.targets import PictureName, add_target_flags, picture_of, target_of, which_map
from rsegen.commands.parameters import Force
from rsegen.commands.simulation import spots
from rsegen.params.command import Shell, add_flags, default, flags_in_errors, given

if TYPE_CHECKING:
    from rsegen.standing.spots import Spot


@dataclass(frozen=True, kw_only=True, slots=True)
class _Drawing:
    """The picture that the shell can ask for."""

    output: Annotated[
        PictureName, Shell(help="draw the outlines of the robot on the plan: png, svg, pdf, jpg or webp, by its ending")
    ] = None
    force: Force = False


def add_spots(command: Parser) -> None:
    """Add the flags of `rsegen spots`."""
    epilog = "rsegen drive --route random with the same seed starts there."
    command.explain(spots.__doc__, f"{epilog} {robot_kinds()}")
    add_target_flags(command)
    add_flags(command.add_argument_group("spots"), spots, without=["map"])
    add_flags(command.add_argument_group("output"), _Drawing)
    add_target_recipe_flags(command, ("seed",))


def run_spots(arguments: argparse.Namespace) -> Report:
    """Find and draw them."""
    from rsegen.exporters.pictures.robot_plots import spots_plot
    from rsegen.params.streams import fresh_seed
    from rsegen.robots import robot_of
    from rsegen.simulation.worlds import world_of
    from rsegen.standing.spots import Outline, body_of_size

    picture = picture_of(arguments.output, force=arguments.force)
    with flags_in_errors(spots):
        said = {"seed": fresh_seed()} | given(spots, arguments)
        target = target_of(arguments, () if arguments.target is None else ("seed",))
        scene = world_of(target, arguments.map).scene()
        places = spots(scene, **{name: value for name, value in said.items() if name != "map"})
        if picture:
            size, robot = said.get("size"), said.get("robot", default(spots, "robot"))
            outline = Outline.of(body_of_size(*size) if size else robot_of(robot).body_or_box)
            picture.write(partial(spots_plot, scene, outline, places))
    content = {"map": scene.name, "seed": said["seed"], "spots": [asdict(place) for place in places]}
    lines = [f"{scene.name}, seed {said['seed']}:", *_rows(places)]
    return Report(lines=lines, content=content, notes=which_map(arguments.target, arguments.map))


def _rows(places: Sequence[Spot]) -> Iterator[str]:
    yield "spot    x [m]    y [m]    z [m]  yaw [deg]  tilt [deg]"
    for index, spot in enumerate(places):
        place = "".join(f"{value:9.3f}" for value in (spot.x, spot.y, spot.z))
        yield f"{index:>4}{place}{degrees(spot.yaw):11.1f}{degrees(spot.tilt):12.2f}"
