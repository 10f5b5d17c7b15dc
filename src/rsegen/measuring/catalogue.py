"""The metrics of a map by their names: rsegen's own, all at once or one alone, and metrics of plug-ins.

StepField --metrics--> Metrics --nested--> JSON --flattened--> a row of a table
by, robot --metric_by--> Metric: StepField -> float, NaN if a map has none

Metrics of plug-ins are functions StepField -> float with a name, a unit and help, listed after rsegen's own.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass
from functools import partial
from operator import attrgetter
from typing import Any, TypeAlias

import numpy as np

from rsegen.errors import ParameterError, PluginError, UnknownName, refuse_other, shown
from rsegen.field.crossing import CrossingModel
from rsegen.field.stepfield import StepField
from rsegen.field.steps import Steps, steps
from rsegen.field.traversability import Percolation, percolation
from rsegen.measuring.roughness import Plane, Ruggedness, Scale, Spread, plane, ruggedness, scale, spread
from rsegen.measuring.spectrum import Spectrum, spectrum
from rsegen.params.plugins import failure
from rsegen.params.registry import Contract, Registry
from rsegen.params.sorts import NANOMETRE_DIGITS


@dataclass(frozen=True, kw_only=True, slots=True)
class Metrics:
    """The metrics of one map, by their families; lengths in metres.

    Attributes
    ----------
    spread : Spread
        Distribution of the heights.
    steps : Steps
        Steps between neighbouring blocks.
    plane : Plane
        The plane that fits best, and deviations from it.
    scale : Scale
        How differences of heights grow with distance.
    spectrum : Spectrum
        The power spectrum.
    ruggedness : Ruggedness
        Ruggedness index and area of the surface.
    opening : Percolation
        The smallest steps at which the map can be crossed.
    reach : Any
        What a robot, or limits of steps, can reach; None without one.
    """

    spread: Spread
    steps: Steps
    plane: Plane
    scale: Scale
    spectrum: Spectrum
    ruggedness: Ruggedness
    opening: Percolation
    reach: Any = None


def metrics(field: StepField, robot: CrossingModel | None = None) -> Metrics:
    """Measure a field: its blocks without frames; and the ways across it, frames counted.

    Parameters
    ----------
    field : StepField
        The field.
    robot : Crosser, optional
        For `reach`: a robot, as `rsegen.robot_of("burger")`, or limits of steps, as `rsegen.StepLimits(climb_cm=10)`.

    Returns
    -------
    Metrics
        The metrics.

    Raises
    ------
    ParameterError
        If the field has only frames, or `robot` is neither.
    """
    refuse_other("field", field, StepField)
    _refuse_no_crosser(robot)
    if field.frame.all():
        raise ParameterError("field", "has only frame cells; there is no block to measure")
    families = (part.name for part in fields(Metrics) if robot or part.name != "reach")
    return Metrics(**{family: _FAMILIES[family](field, robot) for family in families})


def nested(value: Any) -> Any:
    """Return metrics as JSON values: dataclasses as objects, numbers rounded to nine decimals, without large arrays."""
    if is_dataclass(value):
        parts = {field.name: getattr(value, field.name) for field in fields(value)}
        return {name: nested(part) for name, part in parts.items() if not isinstance(part, np.ndarray)}
    if isinstance(value, tuple):
        return [nested(part) for part in value]
    return round(value, NANOMETRE_DIGITS) if isinstance(value, float) else value


def flattened(entries: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the scalar values of nested metrics by dotted name, as in `steps.mean`; without counts, lists and places.

    A place (`at`, `margin_at`) is a list, or None on maps that have none, which all have the same names here.
    """
    for name, value in entries.items():
        if isinstance(value, dict) and not name.endswith("counts"):
            yield from flattened(value, f"{prefix}{name}.")
        elif not isinstance(value, (dict, list)) and name.rpartition("_")[2] != "at":
            yield f"{prefix}{name}", value


Measure: TypeAlias = Callable[[StepField], float]

RESERVED = frozenset({"map", "seed", "predictions", *(family.name for family in fields(Metrics))})
"""Columns of every row of `rsegen metrics`, so no metric of a plug-in has such a name."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Metric:
    """A figure of a map.

    Attributes
    ----------
    name : str
        Its name.
    unit : str
        Its unit, such as m; empty for a number without one.
    help : str
        One line on what it is.
    measure : callable
        A function StepField -> float that gives it in `unit`, NaN or None for none.
    """

    name: str
    unit: str
    help: str
    measure: Measure

    @classmethod
    def of(cls, measure: Measure, unit: str = "") -> Metric:
        """Return the metric of a function: its name, and the first line of its docstring."""
        lines = (getattr(measure, "__doc__", None) or "").strip().splitlines()
        return cls(name=getattr(measure, "__name__", "metric"), unit=unit, help="".join(lines[:1]), measure=measure)

    def __call__(self, field: StepField) -> float:
        """Return the figure of a map; PluginError if the function fails, or gives no number."""
        try:
            value: object = self.measure(field)
        except Exception as error:  # it is somebody else's function, and may do anything
            raise PluginError(f"metric {self.name}: {failure(error)}") from error
        if value is None:
            return math.nan
        if not isinstance(value, (int, float, np.number)):
            raise PluginError(f"metric {self.name}: gave {shown(value)}; a metric gives a number, or nan for none")
        try:
            return float(value)
        except OverflowError:  # an integer above 1e308
            return math.inf


def metric(unit: str) -> Callable[[Measure], Metric]:
    """Make a metric of a function StepField -> float; its name and docstring are the metric's name and help.

    Parameters
    ----------
    unit : str
        Unit of what it returns, such as m; empty for a number without one.

    Returns
    -------
    callable
        The decorator, which gives a Metric.
    """
    return lambda measure: Metric.of(measure, unit)


def _problem(metric: Metric) -> str:
    if not metric.name.isidentifier():
        return f"a metric cannot be named {shown(metric.name)}; use letters, digits and _, with no digit first"
    if metric.name in RESERVED:
        return f"a metric cannot be named {metric.name!r}, as rsegen's own are {', '.join(sorted(RESERVED))}"
    if not metric.help:
        return "has no help; the function needs a docstring"
    return "" if callable(metric.measure) else "its measure is no function"


METRICS: Registry[Metric] = Registry(
    "metric",
    group="rsegen.metrics",
    contract=Contract(base=Metric, names=lambda metric: (metric.name,), check=_problem, is_class=False),
)
"""Every metric of plug-ins by its name."""


def custom(field: StepField) -> dict[str, float | None]:
    """Return the metrics of plug-ins, of one map; None if a map has none."""
    figures = {name: metric(field) for name, metric in METRICS.items()}
    return {name: round(value, NANOMETRE_DIGITS) if math.isfinite(value) else None for name, value in figures.items()}


By: TypeAlias = str | Measure
"""The name of a metric, or a function StepField -> float."""

RMS = "steps.rms"

_LENGTHS = (
    *("spread.lowest", "spread.highest", "spread.mean", "spread.deviation"),
    *("steps.mean", RMS, "steps.highest", "plane.residual", "ruggedness.tri", "ruggedness.riley"),
    *("opening.west_east", "opening.south_north"),
)
_NUMBERS = (
    *("spread.variation", "spread.entropy", "plane.slope", "scale.hurst", "ruggedness.surface_ratio"),
    *("spectrum.west_east.exponent", "spectrum.south_north.exponent"),
)
_SIDES = ("reach.west_east", "reach.south_north")
_POSES = "reach.poses."
_LENGTHS_OF_A_ROBOT = (
    *(f"{side}.{what}" for side in _SIDES for what in ("length", "cost")),
    *(f"{_POSES}clearance_median", f"{_POSES}clearance_least"),
)
_ANGLES_OF_A_ROBOT = (
    *(f"{side}.{what}" for side in _SIDES for what in ("tilt", "margin")),
    *(f"{_POSES}tilt_median", f"{_POSES}tilt_p90"),
)
_NUMBERS_OF_A_ROBOT = (
    *("reach.climbable", "reach.droppable", "reach.coverage", f"{_POSES}stands", f"{_POSES}ambiguous"),
    *(f"{side}.{what}_ratio" for side in _SIDES for what in ("length", "cost")),
)
OF_A_ROBOT = frozenset({*_LENGTHS_OF_A_ROBOT, *_ANGLES_OF_A_ROBOT, *_NUMBERS_OF_A_ROBOT})

UNITS: Mapping[str, str] = {
    **dict.fromkeys((*_LENGTHS, *_LENGTHS_OF_A_ROBOT), "m"),
    **dict.fromkeys(_ANGLES_OF_A_ROBOT, "rad"),
    **dict.fromkeys((*_NUMBERS, *_NUMBERS_OF_A_ROBOT), ""),
}
"""Every metric of rsegen's own that is a number, and its unit."""


def metric_by(by: By, robot: CrossingModel | None = None) -> Metric:
    """Return the metric of a name, of rsegen's own or of a plug-in, or of a function StepField -> float.

    robot: metrics named `reach` need it, for `opening` its width counts, and others do not depend on it. ParameterError
    if it is missing or does not apply, UnknownName for another name.
    """
    # First what is refused whatever the name is; then a function, rsegen's own metrics, and those of plug-ins.
    _refuse_no_crosser(robot)
    if robot is not None and not (isinstance(by, str) and by.startswith(("reach.", "opening."))):
        name = by if isinstance(by, str) else "a function"
        raise ParameterError(
            "robot", f"{name} does not depend on a robot; use by='reach.west_east.cost', or leave robot out"
        )
    if callable(by):
        return by if isinstance(by, Metric) else Metric.of(by)
    if isinstance(by, str) and by in UNITS:
        if by in OF_A_ROBOT and robot is None:
            raise ParameterError("by", f"{by} needs a robot; set robot too")
        return Metric(name=by, unit=UNITS[by], help="", measure=partial(_measured, by, robot))
    if not isinstance(by, str) or by not in METRICS:
        raise UnknownName.among("by", "metric", by, [*UNITS, *METRICS])
    return METRICS[by]


def _refuse_no_crosser(robot: object) -> None:
    if robot is not None and not isinstance(robot, CrossingModel):
        problem = f"{shown(robot)} is neither a robot nor limits of steps"
        raise ParameterError("robot", f"{problem}; use rsegen.robot_of('burger') or StepLimits(climb_cm=10)")


def _measured(name: str, robot: CrossingModel | None, field: StepField) -> Any:
    family = next(prefix for prefix in _FAMILIES if name.startswith(f"{prefix}."))
    try:
        return attrgetter(name.removeprefix(f"{family}."))(_FAMILIES[family](field, robot))
    except AttributeError:  # limits of steps have no poses, and a robot's poses no shares of steps
        needed = (
            "a robot"
            if name.startswith(_POSES) or name.endswith((".tilt", ".margin"))
            else "limits of steps, as in 10,10,0"
        )
        raise ParameterError("by", f"{name} is measured with {needed}") from None


_FAMILIES: Mapping[str, Callable[[StepField, Any], Any]] = {
    "spread": lambda field, _: spread(field),
    "steps": lambda field, _: steps(field),
    "plane": lambda field, _: plane(field),
    "scale": lambda field, _: scale(field),
    "spectrum": lambda field, _: spectrum(field),
    "ruggedness": lambda field, _: ruggedness(field),
    "opening": lambda field, robot: percolation(field, robot.width if robot else 0.0),
    "reach.west_east": lambda field, robot: robot.crossing(field, 0),
    "reach.south_north": lambda field, robot: robot.crossing(field, 1),
    "reach.poses": lambda field, robot: robot.pose_statistics(field),
    "reach": lambda field, robot: robot.reach(field),
}
"""Function that measures each part of the metrics; longer names come first, as the first prefix that fits is taken."""
