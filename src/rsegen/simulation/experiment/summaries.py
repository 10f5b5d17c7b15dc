"""Figures of several trials of a cell as one: medians, limits and means."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import pi, sqrt
from statistics import fmean, median, stdev

from rsegen.simulation.experiment.plan import Cell
from rsegen.simulation.experiment.results import Results
from rsegen.simulation.experiment.trial import Outcome

RESTING = 0.5
"""Robots rested in a cell if they were stuck for more than this share of the time, in the mean over robots and
trials."""


def outcomes_of(results: Results, row: int, size: int, pace: str) -> Sequence[Outcome]:
    """The outcomes of a cell; none if it was not tried yet."""
    return results.get(Cell(row=row, size=size, pace=pace), [])


def known(outcomes: Iterable[Outcome], name: str) -> list[float]:
    """A figure of those outcomes that have it."""
    return [value for value in (getattr(one, name) for one in outcomes) if value is not None]


def median_of(outcomes: Iterable[Outcome], name: str) -> float | None:
    """The median of a figure of outcomes; None if none has it."""
    found = known(outcomes, name)
    return median(found) if found else None


def mean_of(outcomes: Iterable[Outcome], name: str) -> float | None:
    """The mean of a figure of outcomes; None if none has it."""
    found = known(outcomes, name)
    return fmean(found) if found else None


def rtf_limits(outcomes: Sequence[Outcome]) -> tuple[float, float, float] | None:
    """The least, the mean and the most real-time factor that were registered over all trials; None without any."""
    least, mean, most = (known(outcomes, name) for name in ("rtf_min", "rtf", "rtf_max"))
    return (min(least), fmean(mean), max(most)) if least and mean and most else None


def standard_error(values: Sequence[float]) -> float:
    """The standard error of the median of two or more values, if they are normally distributed."""
    return sqrt(pi / 2 / len(values)) * stdev(values)


def rested(outcomes: Sequence[Outcome]) -> bool:
    """Whether the robots rested for most of the time."""
    return (mean_of(outcomes, "stuck") or 0.0) > RESTING
