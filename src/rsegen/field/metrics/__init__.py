"""The metrics of a map: roughness, and traversability for a robot; every module computes one family of them.

StepField --metrics--> Metrics, in metres; docs/metrics.md has every formula with its source.
"""

from rsegen.field.limits import StepLimits
from rsegen.field.metrics.catalogue import Metrics, metrics
from rsegen.field.metrics.roughness import Plane, Scale, Spread, Steps
from rsegen.field.metrics.spectrum import ProfileSpectrum, Spectrum
from rsegen.field.metrics.traversability import Crossing, Traversability

__all__ = [
    "Crossing",
    "Metrics",
    "Plane",
    "ProfileSpectrum",
    "Scale",
    "Spectrum",
    "Spread",
    "StepLimits",
    "Steps",
    "Traversability",
    "metrics",
]
