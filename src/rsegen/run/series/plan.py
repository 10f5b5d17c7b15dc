"""The maps of a series: one recipe for each, with its own difficulty."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated

from rsegen.errors import ParameterError, shown
from rsegen.field.metrics.by_name import RMS, By, metric_by
from rsegen.field.metrics.custom import Metric
from rsegen.field.robot_limits import RobotLimits
from rsegen.params.sorts import Flag, Float, validate
from rsegen.recipe.recipe import Recipe

DIGITS = 6
"""Decimals of a difficulty, so that recipes stay short."""


@dataclass(frozen=True, kw_only=True, slots=True)
class SeriesPlan:
    """As many maps as the recipe has, of difficulty `from_` to `to` in equal steps.

    Their target rms steps lie on a straight line: difficulty * the mean rms step of all their fields as designed. So a
    field that is rougher than others is flattened more, and one that is less rough less. by, robot: another metric that
    rises so, from the mean of the level fields to the mean of the fields as designed.
    """

    recipe: Recipe
    from_: Annotated[float, Float(0, 1, help="difficulty of the first map")] = 0.1
    to: Annotated[float, Float(0, 1, help="difficulty of the last map")] = 1.0
    same_field: Annotated[bool, Flag(help="one field at rising difficulty; else every map is another field")] = False
    by: By = RMS
    robot: RobotLimits | None = None

    def __post_init__(self) -> None:
        validate(self)
        if self.from_ > self.to:
            raise ParameterError("from", f"{shown(self.from_)} is above to, {shown(self.to)}; a series rises")
        if self.recipe.maps < 2:
            raise ParameterError("maps", f"{self.recipe.maps} map is not a series; give 2 or more")
        if self.recipe.difficulty != 1:
            given = shown(self.recipe.difficulty)
            raise ParameterError("difficulty", f"{given} is for maps of one difficulty; give from and to instead")
        self.whole(self.recipe.maps - 1)
        _ = self.metric

    @property
    def metric(self) -> Metric:
        """What rises from map to map."""
        return metric_by(self.by, self.robot)

    @property
    def fields(self) -> range:
        """The number of one map for each different field."""
        return range(1 if self.same_field else self.recipe.maps)

    def difficulty(self, number: int) -> float:
        """The difficulty of map `number`, counted from 0, with the mean of the fields as 1."""
        return round(self.from_ + (self.to - self.from_) * number / (self.recipe.maps - 1), DIGITS)

    def whole(self, number: int) -> Recipe:
        """The recipe of map `number` and no other, at difficulty 1.

        Maps of one field have the same index, which seeds their random draws; so the recipe's name has their number.
        """
        if self.same_field:
            return replace(self.recipe, name=f"{self.recipe.name}-{number:04d}", maps=1)
        return self.recipe.alone(self.recipe.first_map + number)

    def map_name(self, number: int) -> str:
        """What map `number` is called."""
        recipe = self.recipe
        if self.same_field:
            return f"{recipe.name}-{number:04d}_{recipe.first_map:04d}"
        return recipe.map_name(recipe.first_map + number)
