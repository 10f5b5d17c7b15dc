"""The flags of the metric by which maps get harder, and of the robot that it is of."""

from __future__ import annotations

import argparse
from typing import Any

from rsegen.errors import ParameterError
from rsegen.field.metrics.catalogue import RMS
from rsegen.field.robot_limits import RobotLimits
from rsegen.params.sorts import parameters


def add_by_flags(group: argparse._ArgumentGroup) -> None:
    """`--by METRIC` and `--robot ROBOT`."""
    text = (
        "what rises evenly: a metric by its name in rsegen metrics --csv, as in opening.west_east or, with a robot, "
        f"reach.west_east.cost (default: {RMS})"
    )
    group.add_argument("--by", default=RMS, metavar="METRIC", help=text)
    text = "with --by: a kind of robot, or climb, drop (default: as climb) and width (default: 0) of one, in cm"
    group.add_argument("--robot", metavar="KIND|CM,CM,CM", help=text)


def by_from(arguments: argparse.Namespace) -> dict[str, Any]:
    """The metric and the robot, as keyword arguments."""
    return {"by": arguments.by, "robot": None if arguments.robot is None else _robot(arguments.robot)}


def _robot(text: str) -> RobotLimits:
    if not text[:1].isdecimal():
        from rsegen.robots import robot

        return robot(text, "--robot").limits
    sorts, numbers = parameters(RobotLimits), text.split(",")
    if len(numbers) > len(sorts):
        raise ParameterError("--robot", f"{len(numbers)} numbers; give climb, drop and width in cm, as in 7,7,30")
    said = zip(sorts.items(), numbers, strict=False)
    return RobotLimits(**{name: sort.check("--robot", sort.parse(number)) for (name, sort), number in said})
