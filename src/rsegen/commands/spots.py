"""`rsegen spots`: places on a map for a start or a goal of a robot."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from rsegen.commands.parameters import MapReference, RobotModel
from rsegen.field.limits import SIDE
from rsegen.params.command import Shell, command
from rsegen.params.sorts import Float, Integer, ListOf
from rsegen.params.streams import SEEDS

if TYPE_CHECKING:
    from rsegen.simulation.worlds import Target
    from rsegen.standing.spots import Spot


@command
def spots(  # noqa: PLR0913  # each is a flag
    target: Target,
    *,
    map: MapReference = None,  # noqa: A002  # the flag's name
    robot: RobotModel = "burger",
    count: Annotated[int, Integer(1, 1000, help="number of spots"), Shell(metavar="N")] = 1,
    size: Annotated[
        tuple[float, float] | None,
        ListOf(SIDE, 2, help="length and width of a robot, in place of --robot"),
        Shell(metavar="L,W"),
    ] = None,
    max_tilt: Annotated[
        float, Float(0.1, 45, unit="degrees", help="largest tilt at which the robot rests"), Shell(metavar="DEG")
    ] = 3.0,
    seed: Annotated[
        int | None, Integer(0, SEEDS - 1, help="seed of the choice"), Shell(default="drawn and printed")
    ] = None,
) -> tuple[Spot, ...]:
    """Find spots on a map: a robot stands there level and firmly, on its wheels or tracks, and can drive away.

    target: as for `rsegen.drive`. At the spots of a seed `rsegen.drive` starts as many robots on a random route.
    UserError if there are too few.
    """
    from math import radians

    from rsegen.params.streams import fresh_seed
    from rsegen.robots import robot_of
    from rsegen.simulation.driving.robot_runs import spot_generator, spots_on_map
    from rsegen.simulation.worlds import world_of
    from rsegen.standing.spots import body_of_size

    body = robot_of(robot).body_or_box if size is None else body_of_size(*size)
    rng = spot_generator(fresh_seed() if seed is None else seed)
    return spots_on_map(world_of(target, map).scene().field, body, count, rng, most_tilt=radians(max_tilt))
