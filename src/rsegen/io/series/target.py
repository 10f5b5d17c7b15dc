"""What each map of a series should measure: targets on a straight line, and the recipes whose maps reach them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import fsum
from typing import NamedTuple

from rsegen.field.metrics.steps import steps
from rsegen.io.series.plan import DIGITS, SeriesPlan
from rsegen.recipe.building import build
from rsegen.recipe.recipe import Recipe

_HALVINGS = 12
"""Of the interval 0..1 in the search for the difficulty of a constrained map: finer than one block changes it."""


class MapTarget(NamedTuple):
    """A map's recipe, the rms step of its field as designed, and the rms step that it should have, metres."""

    recipe: Recipe
    rms_full: float | None
    rms: float


def rms_full(plan: SeriesPlan, number: int) -> float | None:
    """The rms step of the field of map `number` as designed, metres; None if it has no steps."""
    return _rms(plan.whole(number))


def mean(found: Sequence[float | None]) -> float:
    """The mean of rms steps; a field without steps counts as 0."""
    return fsum(each or 0 for each in found) / len(found)


def map_target(plan: SeriesPlan, number: int, at_one: float) -> MapTarget:
    """The target of map `number`, if difficulty 1 is an rms step of `at_one`; at most its field as designed."""
    whole, difficulty = plan.whole(number), plan.difficulty(number)
    full, rms = _rms(whole), difficulty * at_one
    share = _share(whole, rms, full) if full else difficulty
    return MapTarget(replace(whole, difficulty=round(share, DIGITS)), full, rms)


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
