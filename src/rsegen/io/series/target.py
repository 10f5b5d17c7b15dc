"""The straight line that a series follows, and the recipes whose maps lie on it."""

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
"""Of 0..1, for the difficulty of a map that keeps to constraints: finer than what a block changes."""


class MapTarget(NamedTuple):
    """A map's recipe, and the rms steps of its field as it is and of the line at its place, metres."""

    recipe: Recipe
    rms_full: float | None
    rms: float


def rms_full(plan: SeriesPlan, number: int) -> float | None:
    """The rms step of the field of map `number` as it is, metres; None where it has no steps."""
    return _rms(plan.whole(number))


def mean(found: Sequence[float | None]) -> float:
    """The mean of such rms steps, a field without steps counted as 0."""
    return fsum(each or 0 for each in found) / len(found)


def map_target(plan: SeriesPlan, number: int, at_one: float) -> MapTarget:
    """What map `number` is to be, on the line to `at_one` at difficulty 1; at the most its field as it is."""
    whole, difficulty = plan.whole(number), plan.difficulty(number)
    full, rms = _rms(whole), difficulty * at_one
    share = _share(whole, rms, full) if full else difficulty
    return MapTarget(replace(whole, difficulty=round(share, DIGITS)), full, rms)


def _share(whole: Recipe, rms: float, full: float) -> float:
    """The difficulty at which a map measures so much; constraints lower it further, so there it is tried."""
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
