"""`rsegen.spots`: even places on a map, for a start or a goal of a robot."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace

from rsegen.footprints import Footprint, Spot
from rsegen.params.sorts import Float, Integer, ListOf
from rsegen.params.streams import SEEDS, fresh_seed
from rsegen.robots import robot_of
from rsegen.robots.base import SIDE, DrivableRobot
from rsegen.robots.footprint import footprint_of
from rsegen.simulation.driving.robot_runs import spot_generator, spots_on_map
from rsegen.simulation.worlds import Target, world_of

COUNT, SEED = Integer(1, 1000), Integer(0, SEEDS - 1)
SIZE = ListOf(SIDE, 2)
MAX_DIFFERENCE = Float(0, 100_000, unit="cm")


def spots(  # noqa: PLR0913  # each is a flag of the command
    target: Target,
    *,
    map: int | str | None = None,  # noqa: A002  # the flag's name
    robot: str | os.PathLike[str] | DrivableRobot = "burger",
    count: int = 1,
    size: Sequence[float] | None = None,
    max_difference_cm: float | None = None,
    seed: int | None = None,
) -> tuple[Spot, ...]:
    """Even places on a map for a start or a goal: where a robot stands level and nothing else of it touches a block.

    target: as for `rsegen.drive`; robot: a kind, an SDF file or a robot; size: length and width of a robot that stands
    on all of this rectangle, metres, in place of what is known of `robot`; max_difference_cm: the largest height
    difference under the whole robot; by default it is free, as blocks below the others do no harm. At the spots of a
    seed `rsegen.drive` starts as many robots on a random route. UserError if there are too few.
    """
    number, seed = COUNT.check("count", count), fresh_seed() if seed is None else SEED.check("seed", seed)
    footprint = spot_footprint(robot, size, max_difference_cm)
    return spots_on_map(world_of(target, map).scene().field, footprint, number, spot_generator(seed))


def spot_footprint(
    robot: str | os.PathLike[str] | DrivableRobot, size: Sequence[float] | None, max_difference_cm: float | None
) -> Footprint:
    """Return the footprint of a robot, or of a size."""
    if size is not None:
        length, width = SIZE.check("size", size)
        footprint = Footprint.of_size(length, width)
    else:
        footprint = footprint_of(robot_of(robot))
    if max_difference_cm is None:
        return footprint
    return replace(footprint, most=MAX_DIFFERENCE.check("max_difference_cm", max_difference_cm) / 100)
