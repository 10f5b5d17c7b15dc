"""Axes of difficulty: the parameter of a recipe that makes its fields harder, and the levels of trials."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import exp, inf, log, radians, tan
from typing import Any

import numpy as np

from rsegen.errors import ParameterError
from rsegen.field.stepfield import Array
from rsegen.recipe.recipe import Recipe

_PER_DECADE = 100
"""Levels per factor of 10: neighbours differ by 2.3 %, a quarter of the usual precision."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Axis:
    """A parameter of recipes along which fields become harder.

    name: as `rate` takes it; parameter: in a recipe; words: with a gap for the level
    low, high: the ends of the levels; is_rising: whether higher levels are harder
    """

    name: str
    parameter: str
    words: str
    low: float
    high: float
    is_rising: bool = True

    def recipe_at(self, recipe: Recipe, level: float) -> Recipe:
        """Return the recipe of the fields of a level."""
        return replace(recipe, **self.parameters_at(recipe, level))

    def parameters_at(self, recipe: Recipe, level: float) -> dict[str, Any]:
        """Return the parameter, by its name, that gives the fields of a recipe a level."""
        return {self.parameter: level}

    def place(self, level: float) -> float:
        """Return where a level is on the axis of a psychometric curve: its logarithm, larger for harder fields."""
        return log(level) if self.is_rising else -log(level)

    def level(self, place: float) -> float:
        """Return the level at a place."""
        return exp(place if self.is_rising else -place)

    def level_within(self, place: float) -> float:
        """Return the level at a place; infinity or 0 beyond the ends of the axis, as no field was tried there."""
        first, last = self.ends
        if first <= place <= last:
            return self.level(place)
        return inf if (place > last) == self.is_rising else 0.0

    @property
    def ends(self) -> tuple[float, float]:
        """The places of the easiest and of the hardest level."""
        first, last = sorted((self.place(self.low), self.place(self.high)))
        return first, last

    @property
    def candidates(self) -> Array:
        """The places at which robots are tried, from the easiest to the hardest: of levels of three digits."""
        exponents = np.arange(round(_PER_DECADE * np.log10(self.low)), round(_PER_DECADE * np.log10(self.high)) + 1)
        levels = [float(f"{10 ** (exponent / _PER_DECADE):.3g}") for exponent in exponents]
        return np.sort([self.place(level) for level in levels if self.low <= level <= self.high])

    def tried(self, place: float) -> float:
        """Return the level of three digits at a place."""
        return float(f"{self.level(place):.3g}")

    def shown(self, *levels: float) -> str:
        """Return a level in words, with the ends of its interval, if they are given: `a unit of 6.1 cm [5.8, 6.5]`.

        An end beyond the axis is not a number: `a difficulty of 0.9 [0.7, more than 1]`.
        """
        level, *ends = map(self._number, levels)
        return self.words.format(level) + (f" [{', '.join(ends)}]" if ends else "")

    def _number(self, level: float) -> str:
        if 0 < level < inf:
            return f"{level:.3g}"
        return f"more than {self.high:g}" if level else f"less than {self.low:g}"


@dataclass(frozen=True, kw_only=True, slots=True)
class Slope(Axis):
    """The angle of a slope of one unit per block, degrees, which decides the unit."""

    def parameters_at(self, recipe: Recipe, level: float) -> dict[str, Any]:
        """Return the unit that has this slope, to a thousandth of a centimetre."""
        return {self.parameter: round(tan(radians(level)) * recipe.block_width_cm, 3)}


AXES = {
    axis.name: axis
    for axis in (
        # From steps that stop no wheel to steps that nobody climbs.
        Axis(name="unit", parameter="unit_cm", words="a unit of {} cm", low=0.05, high=100.0),
        Axis(name="difficulty", parameter="difficulty", words="a difficulty of {}", low=0.01, high=1.0),
        Axis(
            name="block_width",
            parameter="block_width_cm",
            words="blocks of {} cm",
            low=1.0,
            high=200.0,
            is_rising=False,
        ),
        Slope(name="slope", parameter="unit_cm", words="a slope of {} degrees", low=1.0, high=80.0),
    )
}
"""Every axis by its name. Narrow blocks are harder than wide ones, as more wheels meet a step at once."""


def refuse_unusable(axis: Axis, recipe: Recipe) -> None:
    """Raise a ParameterError if the fields of a recipe do not depend on the level of an axis."""
    if not recipe.obstacles:
        raise ParameterError("recipe", "has no obstacle, so its fields are flat at every level; add one")
    if axis.name == "difficulty" and recipe.difficulty != 1:
        raise ParameterError("recipe", f"has difficulty {recipe.difficulty}; leave it at 1 on the axis difficulty")
