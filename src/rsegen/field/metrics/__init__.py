"""The metrics of a map: roughness, and traversability for a robot; every module computes one family of them.

StepField --metrics--> Metrics, in metres; docs/metrics.md has every formula with its source.
"""

from __future__ import annotations

from dataclasses import dataclass

from rsegen.errors import ParameterError
from rsegen.field.metrics.percolation import Percolation, percolation
from rsegen.field.metrics.ruggedness import Ruggedness, ruggedness
from rsegen.field.metrics.scale import Scale, scale
from rsegen.field.metrics.spread import Spread, spread
from rsegen.field.metrics.steps import Steps, steps
from rsegen.field.metrics.traversability import Crossing, Traversability, traversability
from rsegen.field.robot_limits import RobotLimits
from rsegen.field.stepfield import StepField


@dataclass(frozen=True, kw_only=True, slots=True)
class Metrics:
    """The metrics of one map; `reach`, its traversability, is None if no robot was given."""

    spread: Spread
    steps: Steps
    scale: Scale
    ruggedness: Ruggedness
    opening: Percolation
    reach: Traversability | None = None


def metrics(field: StepField, climber: RobotLimits | None = None) -> Metrics:
    """The metrics of a field: of its blocks without frames; and of the paths across it, frames counted."""
    if field.frame.all():
        raise ParameterError("field", "has only frame cells; there is no block to measure")
    return Metrics(
        spread=spread(field),
        steps=steps(field),
        scale=scale(field),
        ruggedness=ruggedness(field),
        opening=percolation(field, climber.width if climber else 0.0),
        reach=traversability(field, climber) if climber else None,
    )


__all__ = [
    "Crossing",
    "Metrics",
    "Percolation",
    "RobotLimits",
    "Ruggedness",
    "Scale",
    "Spread",
    "Steps",
    "Traversability",
    "metrics",
]
