"""One metric of a map, by its name in `rsegen metrics --csv` or as a function: what maps are ordered by.

by, robot --metric_by--> Metric: StepField -> float, NaN where a map has none
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from operator import attrgetter
from typing import Any, TypeAlias

from rsegen.errors import ParameterError, UnknownName, shown
from rsegen.field.metrics.custom import METRICS, Measure, Metric
from rsegen.field.metrics.percolation import percolation
from rsegen.field.metrics.ruggedness import ruggedness
from rsegen.field.metrics.scale import scale
from rsegen.field.metrics.spread import spread
from rsegen.field.metrics.steps import steps
from rsegen.field.metrics.traversability import crossing, traversability
from rsegen.field.robot_limits import RobotLimits
from rsegen.field.stepfield import StepField

By: TypeAlias = str | Measure
"""The name of a metric, or a function StepField -> float."""

RMS = "steps.rms"

_LENGTHS = (
    *("spread.lowest", "spread.highest", "spread.mean", "spread.deviation"),
    *("steps.mean", RMS, "steps.highest", "ruggedness.tri", "ruggedness.riley"),
    *("opening.west_east", "opening.south_north"),
)
_NUMBERS = ("spread.variation", "spread.entropy", "scale.hurst", "ruggedness.surface_ratio")
_SIDES = ("reach.west_east", "reach.south_north")
_LENGTHS_OF_A_ROBOT = tuple(f"{side}.{what}" for side in _SIDES for what in ("length", "cost"))
_NUMBERS_OF_A_ROBOT = (
    *("reach.climbable", "reach.droppable", "reach.cover"),
    *(f"{side}.{what}_ratio" for side in _SIDES for what in ("length", "cost")),
)
OF_A_ROBOT = frozenset({*_LENGTHS_OF_A_ROBOT, *_NUMBERS_OF_A_ROBOT})

UNITS: Mapping[str, str] = {
    **dict.fromkeys((*_LENGTHS, *_LENGTHS_OF_A_ROBOT), "m"),
    **dict.fromkeys((*_NUMBERS, *_NUMBERS_OF_A_ROBOT), ""),
}
"""Every metric of rsegen's own that is one number, and its unit."""


def metric_by(by: By, robot: RobotLimits | None = None) -> Metric:
    """The metric of a name, of rsegen's own or of a plug-in, or of a function StepField -> float.

    robot: those named `reach` need one, for `opening` its width counts, and others are of none. ParameterError if it is
    missing or too much, UnknownName for another name.
    """
    if robot is not None and not isinstance(robot, RobotLimits):
        raise ParameterError("robot", f"{shown(robot)} is not a robot's limits; give RobotLimits(climb_cm=10)")
    if robot is not None and not (isinstance(by, str) and by.startswith(("reach.", "opening."))):
        what = by if isinstance(by, str) else "a function"
        raise ParameterError(
            "robot", f"{what} does not depend on a robot; give by=reach.west_east.cost, or leave robot out"
        )
    if callable(by):
        return by if isinstance(by, Metric) else Metric.of(by)
    if isinstance(by, str) and by in UNITS:
        if by in OF_A_ROBOT and robot is None:
            raise ParameterError("by", f"{by} needs a robot; give robot too")
        return Metric(name=by, unit=UNITS[by], help="", measure=partial(_measured, by, robot))
    if not isinstance(by, str) or by not in METRICS:
        raise UnknownName.among("by", "metric", by, [*UNITS, *METRICS])
    return METRICS[by]


def _measured(name: str, robot: RobotLimits | None, field: StepField) -> Any:
    family = next(prefix for prefix in _FAMILIES if name.startswith(f"{prefix}."))
    return attrgetter(name.removeprefix(f"{family}."))(_FAMILIES[family](field, robot))


_FAMILIES: Mapping[str, Callable[[StepField, Any], Any]] = {
    "spread": lambda field, _: spread(field),
    "steps": lambda field, _: steps(field),
    "scale": lambda field, _: scale(field),
    "ruggedness": lambda field, _: ruggedness(field),
    "opening": lambda field, robot: percolation(field, robot.width if robot else 0.0),
    "reach.west_east": lambda field, robot: crossing(field, robot, 0),
    "reach.south_north": lambda field, robot: crossing(field, robot, 1),
    "reach": traversability,
}
"""How each part of the metrics is measured; those of longer names come first."""
