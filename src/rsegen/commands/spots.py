"""`rsegen spots`: even places on a map, for a start or a goal of a robot."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from rsegen.commands.parameters import MapReference, RobotModel
from rsegen.field.limits import SIDE
from rsegen.params.command import Shell, command
from rsegen.params.sorts import Float, Integer, ListOf
from rsegen.params.streams import SEEDS

if TYPE_CHECKING:
    from rsegen.footprints import Spot
    from rsegen.simulation.worlds import Target


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
    max_difference_cm: Annotated[
        float | None,
        Float(0, 100_000, unit="cm", help="largest height difference under the whole robot"),
        Shell(metavar="CM", default="any; lower blocks under the body are allowed"),
    ] = None,
    seed: Annotated[
        int | None, Integer(0, SEEDS - 1, help="seed of the choice"), Shell(default="drawn and printed")
    ] = None,
) -> tuple[Spot, ...]:
    """Find even places on a map: a robot stands level there, and nothing but its wheels or tracks touches a block.

    target: as for `rsegen.drive`. Level is within 3 degrees. At the spots of a seed `rsegen.drive` starts as many
    robots on a random route. UserError if there are too few.
    """
    from rsegen.params.streams import fresh_seed
    from rsegen.robots.footprint import spot_footprint
    from rsegen.simulation.driving.robot_runs import spot_generator, spots_on_map
    from rsegen.simulation.worlds import world_of

    footprint = spot_footprint(robot, size, max_difference_cm)
    rng = spot_generator(fresh_seed() if seed is None else seed)
    return spots_on_map(world_of(target, map).scene().field, footprint, count, rng)
