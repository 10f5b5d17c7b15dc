"""The difficulty at which a map has a wanted value of a metric, whatever the metric.

recipe, index --span_of--> its values from level ground to the whole map --mean_of--> those of several maps
value --share_of--> the difficulty at which a map has it
"""

from __future__ import annotations

from collections.abc import Sequence
from math import fsum, inf, isnan
from typing import NamedTuple

from rsegen.errors import ParameterError
from rsegen.field.metrics.custom import Metric
from rsegen.recipe.building import build
from rsegen.recipe.recipe import Recipe
from rsegen.recipe.tiles import eased

_HALVINGS = 12
"""Of the interval 0..1 in the search for a difficulty: finer than one block changes most metrics."""


class Span(NamedTuple):
    """The metric of a map that is level, and at its full difficulty; `hardest`: that difficulty, as a share.

    If the whole map has no value, as the cost for a robot that cannot cross it, full is that of the hardest that has.
    """

    level: float
    full: float
    hardest: float = 1.0

    def value(self, difficulty: float) -> float:
        """The value at a share of the way from level to full."""
        return self.level + difficulty * (self.full - self.level)


def mean_of(spans: Sequence[Span], name: str) -> Span:
    """The mean of the values of several maps; ParameterError if they stay the same, with the name of the metric."""
    level, full = (fsum(values) / len(spans) for values in zip(*((one.level, one.full) for one in spans), strict=True))
    if level == full:
        raise ParameterError("by", f"{name} is {level:g} at difficulty 0 and at 1; give a metric that changes")
    return Span(level, full)


def span_of(recipe: Recipe, index: int, metric: Metric) -> Span:
    """The values of a metric over the difficulties of map `index`; ParameterError if its level ground has none."""
    level, full = (_value(recipe, index, metric, share) for share in (0.0, 1.0))
    if isnan(level):
        name = recipe.map_name(index)
        raise ParameterError("by", f"{metric.name} of {name} has no value even at difficulty 0; give another metric")
    if not isnan(full):
        return Span(level, full)
    low, high = 0.0, 1.0
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        low, high = (low, middle) if isnan(_value(recipe, index, metric, middle)) else (middle, high)
    return Span(level, _value(recipe, index, metric, low), low)


def share_of(recipe: Recipe, index: int, metric: Metric, own: Span, line: Span, difficulty: float) -> float:
    """The share of the recipe's difficulty at which map `index` is nearest to the value of a difficulty on a line.

    own: its values. It is the hardest at most, the difficulty itself if the values are all the same, and otherwise the
    nearest that a bisection comes by; if several difficulties have that value, the least of them.
    """
    wanted, sign = line.value(difficulty), 1 if own.full >= own.level else -1
    if own.level == own.full:
        return difficulty
    if sign * (wanted - own.level) <= 0:
        return 0.0
    if sign * (wanted - own.full) >= 0:
        return own.hardest
    low, high = 0.0, own.hardest
    seen = {low: own.level, high: own.full}
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        value = _value(recipe, index, metric, middle)
        seen[middle] = sign * inf if isnan(value) else value
        low, high = (middle, high) if sign * (wanted - seen[middle]) > 0 else (low, middle)
    return min(seen, key=lambda share: (abs(wanted - seen[share]), share))


def _value(recipe: Recipe, index: int, metric: Metric, share: float) -> float:
    return metric(build(eased(recipe, share), index))
