"""Metrics of plug-ins: functions StepField -> float with a name, a unit and help, listed beside rsegen's own."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from rsegen.errors import PluginError, shown
from rsegen.field.stepfield import NANOMETRE_DIGITS, StepField
from rsegen.params.contract import Contract
from rsegen.params.plugins import failure
from rsegen.params.registry import Registry

Measure: TypeAlias = Callable[[StepField], float]

RESERVED = frozenset({"map", "seed", "spread", "steps", "scale", "ruggedness", "opening", "reach"})
"""What a row of `rsegen metrics` says of every map, so no metric of a plug-in has such a name."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Metric:
    """A figure of a map: `measure` gives it in `unit`, NaN or None for none; `help` says what it is, in one line."""

    name: str
    unit: str
    help: str
    measure: Measure

    @classmethod
    def of(cls, measure: Measure, unit: str = "") -> Metric:
        """The metric of a function: its name, and the first line of its docstring."""
        lines = (getattr(measure, "__doc__", None) or "").strip().splitlines()
        return cls(name=getattr(measure, "__name__", "metric"), unit=unit, help="".join(lines[:1]), measure=measure)

    def __call__(self, field: StepField) -> float:
        """The figure of a map; PluginError where the function fails, or gives no number."""
        try:
            value: object = self.measure(field)
        except Exception as error:  # it is somebody else's function, and may do anything
            raise PluginError(f"metric {self.name}: {failure(error)}") from error
        if value is None:
            return math.nan
        if not isinstance(value, (int, float, np.number)):
            raise PluginError(f"metric {self.name}: gave {shown(value)}; a metric gives a number, or nan for none")
        return float(value)


def metric(unit: str) -> Callable[[Measure], Metric]:
    """Make a metric of a function StepField -> float; its name and docstring are the metric's name and help."""
    return lambda measure: Metric.of(measure, unit)


def _problem(found: Metric) -> str:
    if not found.name.isidentifier() or found.name in RESERVED:
        return f"a metric cannot be named {found.name!r}; give letters, digits and _, and none of rsegen's own names"
    if not found.help:
        return "has no help; give the function a docstring"
    return "" if callable(found.measure) else "its measure is no function"


METRICS: Registry[Metric] = Registry(
    "metric",
    group="rsegen.metrics",
    contract=Contract(base=Metric, names=lambda found: (found.name,), check=_problem, is_class=False),
)
"""Every metric of plug-ins by its name."""


def custom(field: StepField) -> dict[str, float | None]:
    """The metrics of plug-ins, of one map; None where there is none."""
    figures = {name: metric(field) for name, metric in METRICS.items()}
    return {name: round(value, NANOMETRE_DIGITS) if math.isfinite(value) else None for name, value in figures.items()}
