"""How rough a map is and what a robot can do on it, in many numbers: one file = one family; no single one is enough.

StepField --metrics--> Metrics, in metres; docs/metrics.md has every formula with its source.
"""

from __future__ import annotations

from dataclasses import dataclass

from rsegen.errors import ParameterError
from rsegen.field.metrics.opening import Opening, opening
from rsegen.field.metrics.reach import Crossing, Reach, reach
from rsegen.field.metrics.ruggedness import Ruggedness, ruggedness
from rsegen.field.metrics.scale import Scale, scale
from rsegen.field.metrics.spread import Spread, spread
from rsegen.field.metrics.steps import Steps, steps
from rsegen.field.robot_limits import RobotLimits
from rsegen.field.stepfield import StepField


@dataclass(frozen=True, kw_only=True, slots=True)
class Metrics:
    """The metrics of one map; `reach` is there where a robot was given."""

    spread: Spread
    steps: Steps
    scale: Scale
    ruggedness: Ruggedness
    opening: Opening
    reach: Reach | None = None


Climber = RobotLimits
"""Its name in rsegen 0.1."""


def metrics(field: StepField, climber: RobotLimits | None = None) -> Metrics:
    """The metrics of a field: of its blocks alone; and, frames counted, of the ways over it, for a robot if given."""
    if field.frame.all():
        raise ParameterError("field", "is all frame; there is no block to measure")
    return Metrics(
        spread=spread(field),
        steps=steps(field),
        scale=scale(field),
        ruggedness=ruggedness(field),
        opening=opening(field, climber.width if climber else 0.0),
        reach=reach(field, climber) if climber else None,
    )


__all__ = [
    "Climber",
    "Crossing",
    "Metrics",
    "Opening",
    "Reach",
    "RobotLimits",
    "Ruggedness",
    "Scale",
    "Spread",
    "Steps",
    "metrics",
]
