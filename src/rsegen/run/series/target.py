"""What each map of a series should measure: targets on a straight line, and the recipes whose maps reach them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import fsum
from typing import NamedTuple

from rsegen.field.metrics.by_name import RMS
from rsegen.field.metrics.steps import steps
from rsegen.recipe.building import build
from rsegen.recipe.difficulty_by import Span, mean_of, share_of, span_of
from rsegen.recipe.recipe import Recipe
from rsegen.run.series.plan import DIGITS, SeriesPlan

_HALVINGS = 12
"""Of the interval 0..1 in the search for the difficulty of a constrained map: finer than one block changes it."""


class MapTarget(NamedTuple):
    """A map's recipe, the value of the metric of its field as designed, and the value that it should have."""

    recipe: Recipe
    full: float | None
    asked: float


def span(plan: SeriesPlan, number: int) -> Span:
    """The metric of the field of map `number`, level and as designed; a field without steps has an rms step of 0."""
    whole = plan.whole(number)
    return Span(0.0, _rms(whole) or 0.0) if plan.by == RMS else span_of(whole, whole.first_map, plan.metric)


def mean(plan: SeriesPlan, spans: Sequence[Span]) -> Span:
    """The values from which and to which the series rises; ParameterError if a metric that is not rms does not."""
    if plan.by == RMS:
        return Span(0.0, fsum(each.full for each in spans) / len(spans))
    return mean_of(spans, plan.metric.name)


def map_target(plan: SeriesPlan, number: int, line: Span) -> MapTarget:
    """The target of map `number` on the line from level to as designed; at most its field as designed."""
    whole, difficulty = plan.whole(number), plan.difficulty(number)
    asked = line.value(difficulty)
    if plan.by == RMS:
        full = _rms(whole)
        share = _share(whole, asked, full) if full else difficulty
    else:
        own = span(plan, number)
        full, share = own.full, share_of(whole, whole.first_map, plan.metric, own, line, difficulty)
    return MapTarget(replace(whole, difficulty=round(share, DIGITS)), full, asked)


def _share(whole: Recipe, rms: float, full: float) -> float:
    """The difficulty at which a map has this rms step; searched for if constraints lower the steps further."""
    if rms >= full or not whole.is_constrained:
        return min(rms / full, 1.0)
    low, high = 0.0, 1.0
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        reached = _rms(replace(whole, difficulty=middle)) or 0.0
        low, high = (middle, high) if reached < rms else (low, middle)
    return high


def _rms(recipe: Recipe) -> float | None:
    return steps(build(recipe, recipe.first_map)).rms
