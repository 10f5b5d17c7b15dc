"""The command `rsegen spots`: spots for a start or a goal of a robot."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from math import degrees
from typing import TYPE_CHECKING, Annotated

from rsegen.cli.flags import (
    add_target_flags,
    add_target_recipe_flags,
    target_of,
    which_map,
)
from rsegen.cli.parameters import Force, MapReference
from rsegen.cli.parser import Parser
from rsegen.cli.report import Report
from rsegen.field.crossing import SIDE, robot_kinds
from rsegen.params.command import Shell, add_flags, command, default, flags_in_errors, given
from rsegen.params.sorts import Float, Integer, ListOf
from rsegen.params.streams import SEEDS
from rsegen.pictures.flags import PictureName, picture_of
from rsegen.robots.parameters import RobotModel

if TYPE_CHECKING:
    from rsegen.standing.outlines import Spot
    from rsegen.writing.target_worlds import Target


@command
def spots(  # noqa: PLR0913  # each is a flag
    target: Target,
    *,
    map: MapReference = None,  # noqa: A002  # the flag's name
    robot: RobotModel = "burger",
    count: Annotated[int, Integer(1, 1000, usual=(1, 20), help="number of spots"), Shell(metavar="N")] = 1,
    size: Annotated[
        Sequence[float] | None,
        ListOf(SIDE, 2, help="length and width of a robot, instead of --robot"),
        Shell(metavar="L,W"),
    ] = None,
    max_tilt: Annotated[
        float, Float(0.1, 45, unit="degrees", help="largest tilt at which the robot rests"), Shell(metavar="DEG")
    ] = 3.0,
    seed: Annotated[
        int | None, Integer(0, SEEDS - 1, help="seed of the choice"), Shell(default="drawn and printed")
    ] = None,
) -> tuple[Spot, ...]:
    """Find spots on a map where a robot stands level and firmly on its wheels or tracks, and can drive away.

    At the spots of a seed `rsegen.drive` starts as many robots on a random route.

    Parameters
    ----------
    target : Recipe, Scene, str or path
        As for `rsegen.drive`.

    Returns
    -------
    tuple of Spot
        The spots.

    Raises
    ------
    UserError
        If there are too few.
    """
    from math import radians

    from rsegen.params.streams import fresh_seed
    from rsegen.robots.lookup import robot_of
    from rsegen.standing.body import body_of_size
    from rsegen.standing.spots import find_spots, spot_generator
    from rsegen.writing.target_worlds import world_of

    body = robot_of(robot).body_or_box if size is None else body_of_size(*size)
    rng = spot_generator(fresh_seed() if seed is None else seed)
    return find_spots(world_of(target, map).scene().field, body, count, rng, most_tilt=radians(max_tilt))


@dataclass(frozen=True, kw_only=True, slots=True)
class _Outlines:
    """The picture that the shell can ask for."""

    output: Annotated[
        PictureName, Shell(help="draw the outlines of the robot on the plan: png, svg, pdf, jpg or webp, by its ending")
    ] = None
    force: Force = False


def add_spots(command: Parser) -> None:
    """Add the flags of `rsegen spots`."""
    epilog = "rsegen drive --route random with the same seed starts there."
    command.explain(spots.__doc__, epilog, robot_kinds)
    add_target_flags(command)
    add_flags(command.group("spots"), spots, without=["map"])
    add_flags(command.group("output"), _Outlines)
    add_target_recipe_flags(command, ("seed",))


def run_spots(arguments: argparse.Namespace) -> Report:
    """Find spots, and draw them if a picture is asked for."""
    from rsegen.params.streams import fresh_seed
    from rsegen.robots.lookup import robot_of
    from rsegen.standing.body import body_of_size
    from rsegen.standing.outlines import Outline
    from rsegen.standing.plots import spots_plot
    from rsegen.writing.target_worlds import world_of

    picture = picture_of(arguments.output, force=arguments.force)
    with flags_in_errors(spots):
        # The seed is drawn here, as the report has to name it.
        values = {"seed": fresh_seed()} | given(spots, arguments)
        target = target_of(arguments, () if arguments.target is None else ("seed",))
        scene = world_of(target, arguments.map).scene()
        places = spots(scene, **values)
        if picture:
            size, robot = values.get("size"), values.get("robot", default(spots, "robot"))
            outline = Outline.of(body_of_size(*size) if size else robot_of(robot).body_or_box)
            picture.write(partial(spots_plot, scene, outline, places))
    content = {"map": scene.name, "seed": values["seed"], "spots": [asdict(place) for place in places]}
    lines = [f"{scene.name}, seed {values['seed']}:", *_rows(places)]
    return Report(lines=lines, content=content, notes=which_map(arguments.target, arguments.map))


def _rows(places: Sequence[Spot]) -> Iterator[str]:
    yield "spot    x [m]    y [m]    z [m]  yaw [deg]  tilt [deg]"
    for index, spot in enumerate(places):
        place = "".join(f"{value:9.3f}" for value in (spot.x, spot.y, spot.z))
        yield f"{index:>4}{place}{degrees(spot.yaw):11.1f}{degrees(spot.tilt):12.2f}"
