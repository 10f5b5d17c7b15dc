"""The way across a map that the metrics find for a robot, as points that it can follow."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from rsegen.field.metrics.percolation import percolation_step
from rsegen.field.metrics.traversability import crossing
from rsegen.field.robot_limits import RobotLimits
from rsegen.field.stepfield import Array, StepField


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class PlannedWay:
    """The cheapest way from west to east; where there is none for the robot, the one whose highest step is least.

    points: (n, 2), x and y in metres, from the ground west of the map to that east of it; crosses: whether the robot's
    limits allow it, None if they are unknown; least_step: of all ways, the least highest step, metres
    """

    points: Array
    crosses: bool | None
    least_step: float

    def __post_init__(self) -> None:
        self.points.setflags(write=False)

    def as_json(self) -> dict[str, object]:
        """What drive.json has of it."""
        return {"crosses": self.crosses, "least_step": round(self.least_step, 9)}

    def csv(self) -> Iterator[str]:
        """The lines of a CSV file."""
        yield "x,y\n"
        for x, y in self.points.tolist():
            yield f"{x:.4f},{y:.4f}\n"


def planned_way(field: StepField, width: float, limits: RobotLimits | None) -> PlannedWay:
    """The way across a field for a robot of a width in metres, with these limits if they are known."""
    least = percolation_step(field, width, 0)
    found = crossing(field, limits, 0) if limits else None
    path = found.path if found and found.crosses else crossing(field, RobotLimits.of(least, width), 0).path
    half = np.array(field.extent) / 2
    return PlannedWay(
        points=(path + 0.5) * field.block_width - half,
        crosses=found.crosses if found else None,
        least_step=least,
    )
