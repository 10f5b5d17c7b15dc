"""Maps as tiles of a terrain or data set: their levels, and the difficulty at which a metric of one has a target value.

The cells of a tile are levels, frames too, and its difficulty is a share of the one that its recipe gives. Several
recipes may go together; each is a kind of tiles. For a metric other than the rms step,

    recipe, index --span_of--> its values on level ground and on the whole map --mean_span--> the range of several maps
    value in that range --share_of--> the difficulty at which a map has it

Both ask for the metric of the map at some difficulties and halve an interval, so the cost is `HALVINGS` maps and
metrics per tile. A metric that does not rise or fall evenly with the difficulty still gets a value between two others,
as bisection keeps one below and one above, but perhaps not the only one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from math import fsum, inf, isnan
from typing import NamedTuple

import numpy as np

from rsegen.errors import ParameterError, shown
from rsegen.field.stepfield import Array, Ints, Levels
from rsegen.measuring.catalogue import Metric
from rsegen.params.sorts import MOST_LEVELS, NANOMETRES
from rsegen.recipe.building import build
from rsegen.recipe.recipe import Recipe


def check_tile(recipe: Recipe) -> None:
    """Raise a ParameterError if the maps of a recipe cannot be tiles."""
    if isinstance(recipe.difficulty, tuple):
        bounds = shown(list(recipe.difficulty))
        raise ParameterError("difficulty", f"{bounds} is a range, and tiles have their own; use one number")
    frame = recipe.frame_height_cm
    # Lengths that differ by less than a nanometre are equal: of floats 11.43 % 3.81 is 3.81.
    if recipe.boundary != "none" and round(abs(frame - _frame_level(recipe) * recipe.unit_cm) * NANOMETRES / 100):
        problem = f"{frame:g} is no multiple of the unit, {recipe.unit_cm:g}"
        raise ParameterError("frame_height_cm", f"{problem}; the frames of a tile are blocks like others")
    if top_of_tile(recipe) >= MOST_LEVELS:
        problem = f"{frame:g} cm are {_frame_level(recipe):,} units, above the highest level, {MOST_LEVELS - 1}"
        raise ParameterError("frame_height_cm", f"{problem}; the frames of a tile are blocks like others")
    if recipe.boundary != "none" and recipe.frame_friction is not None and not recipe.is_of_one_friction:
        problem = f"{recipe.frame_friction:g} acts on no tile, whose frames are blocks like others"
        raise ParameterError("frame_friction", f"{problem}; leave it out, or the frames: boundary 'none'")


def amid(levels: Ints | Array) -> Ints | Array:
    """Return the highest cell of those that meet in the middle of each map: (..., n_x, n_y) -> (...,)."""
    # One cell along a side with an odd number of them, two with an even one.
    x, y = (slice((cells - 1) // 2, cells // 2 + 1) for cells in levels.shape[-2:])
    return np.asarray(levels[..., x, y].max(axis=(-2, -1)))


def eased(recipe: Recipe, share: float) -> Recipe:
    """Return the recipe at a share of its difficulty, which is one number."""
    return replace(recipe, difficulty=float(share) * recipe.difficulty)  # type: ignore[operator]  # one number


def top_of_tile(recipe: Recipe) -> int:
    """Return the largest level that any cell of a tile may have, frames counted."""
    return recipe.highest_level if recipe.boundary == "none" else max(recipe.highest_level, _frame_level(recipe))


def tile_levels(recipe: Recipe, index: int) -> Levels:
    """Return the levels of the cells of map `index`, frames as blocks of their height: (n_x, n_y)."""
    field = build(recipe, index)
    return np.where(field.frame, np.int16(_frame_level(recipe)), field.levels).astype(np.int16)


def _frame_level(recipe: Recipe) -> int:
    return round(recipe.frame_height_cm / recipe.unit_cm)


def refuse_unlike(recipes: Sequence[Recipe], names: Iterable[str]) -> None:
    """Raise a ParameterError for the first of these parameters in which a recipe differs from the first one."""
    for index, recipe in enumerate(recipes):
        for name in names:
            own, others = getattr(recipe, name), getattr(recipes[0], name)
            if own != others:
                problem = f"{shown(own)}, and {shown(others)} in the first recipe; use the same for all"
                raise ParameterError(f"recipes[{index}].{name}", problem)


def kind_of_column(column: int, columns: int, kinds: int) -> int:
    """Return the kind of a column: all kinds have equally many neighbouring columns, as far as that goes."""
    return column * kinds // columns


HALVINGS = 12
"""Halvings of the interval 0..1 in the search for a difficulty: finer than one block changes most metrics."""


def bisected(is_enough: Callable[[float], bool], most: float = 1.0) -> tuple[float, float]:
    """Return the ends of what halvings leave of 0..most: the lower is not enough, or 0; the upper is, or `most`."""
    low, high = 0.0, most
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        low, high = (low, middle) if is_enough(middle) else (middle, high)
    return low, high


class Span(NamedTuple):
    """A metric's value on level ground and on the hardest map that has one; `hardest`: its difficulty, as a share.

    The hardest map is the whole one, unless that has no value, as the cost for a robot that cannot cross it.
    """

    level: float
    full: float
    hardest: float = 1.0

    def value(self, difficulty: float) -> float:
        """Return the value at a share of the way from level to full."""
        return self.level + difficulty * (self.full - self.level)


def mean_span(spans: Sequence[Span], name: str) -> Span:
    """Return the mean of several spans of the metric `name`; ParameterError if its level and full are equal."""
    level, full = (
        fsum(values) / len(spans) for values in zip(*((span.level, span.full) for span in spans), strict=True)
    )
    if level == full:
        raise ParameterError("by", f"{name} is {level:g} at difficulty 0 and at 1; choose a metric that changes")
    return Span(level, full)


def span_of(recipe: Recipe, index: int, metric: Metric) -> Span:
    """Return the span of a metric over the difficulties of map `index`; ParameterError if level ground has no value."""
    level, full = (_value(recipe, index, metric, share) for share in (0.0, 1.0))  # nan if a robot cannot cross it
    if isnan(level):
        name = recipe.map_name(index)
        raise ParameterError("by", f"{metric.name} of {name} has no value even at difficulty 0; choose another metric")
    if not isnan(full):
        return Span(level, full)
    hardest, _ = bisected(lambda share: isnan(_value(recipe, index, metric, share)))
    return Span(level, _value(recipe, index, metric, hardest), hardest)


def share_of(recipe: Recipe, index: int, metric: Metric, own: Span, line: Span, difficulty: float) -> float:
    """Return the share of the recipe's difficulty at which map `index` is nearest to a target value.

    own: the span of the map. The target lies at `difficulty` on the span `line`. The share is `own.hardest` at
    most, the difficulty itself if all values are the same, and otherwise the nearest of the shares that a bisection
    tries; of equally near ones, the least.
    """
    target, sign = line.value(difficulty), 1 if own.full >= own.level else -1
    if own.level == own.full:
        return difficulty
    # Beyond the ends of its own span the map has no value to search for: the end is the nearest.
    if sign * (target - own.level) <= 0:
        return 0.0
    if sign * (target - own.full) >= 0:
        return own.hardest
    tried = {0.0: own.level, own.hardest: own.full}

    def is_enough(share: float) -> bool:
        value = _value(recipe, index, metric, share)
        tried[share] = sign * inf if isnan(value) else value  # without a value it is too hard
        return sign * (target - tried[share]) <= 0

    # As blocks are rounded, the metric may go up and down: the nearest of all that were tried counts, not the last.
    bisected(is_enough, own.hardest)
    return min(tried, key=lambda share: (abs(target - tried[share]), share))


def _value(recipe: Recipe, index: int, metric: Metric, share: float) -> float:
    """Return the metric of map `index` at a share of the recipe's difficulty; nan if it has no value."""
    return metric(build(eased(recipe, share), index))
