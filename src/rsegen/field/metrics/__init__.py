"""The metrics of a map: roughness, and traversability for a robot; every module computes one family of them.

StepField --metrics--> Metrics, in metres; docs/metrics.md has every formula with its source.
"""

from rsegen.field.metrics.catalogue import Metrics, metrics
from rsegen.field.metrics.roughness import Scale, Spread, Steps
from rsegen.field.metrics.traversability import Crossing, Traversability
from rsegen.field.robot_limits import RobotLimits

__all__ = [
    "Crossing",
    "Metrics",
    "RobotLimits",
    "Scale",
    "Spread",
    "Steps",
    "Traversability",
    "metrics",
]
