"""The maps of a series: their recipes, what each should measure, and the rows of series.csv.

    SeriesPlan --span, mean--> a straight line from the first map to the last --map_target--> a recipe for each map
    --series_row--> what the map measures; lengths in metres

Difficulty scales the rms step between neighbouring blocks. So that a series rises evenly although its fields differ, a
map gets the difficulty at which its own rms step lies on the line: the quotient of both or, for a map whose constraints
flatten it further, a value searched by bisection. Cost: building each field once, constrained ones twelve times more.
What breaks it: a field that is flatter as designed than the line asks for, which stays as it is (docs/difficulty.md).
"""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields, replace
from math import fsum, isnan
from typing import NamedTuple

from rsegen.datasets.difficulty_tiles import Span, bisected, mean_span, share_of, span_of
from rsegen.errors import ParameterError, shown
from rsegen.field.crossing import CrossingModel
from rsegen.field.steps import steps
from rsegen.field.traversability import percolation
from rsegen.measuring.catalogue import RMS, By, Metric, metric_by
from rsegen.measuring.parameters import From, SameField, To
from rsegen.measuring.roughness import spread
from rsegen.params.sorts import NANOMETRE_DIGITS, validate
from rsegen.recipe.building import build
from rsegen.recipe.recipe import Recipe
from rsegen.scene.scene import Scene

DIGITS = 6
"""Decimals of a difficulty, so that recipes stay short; a millionth is far less than a level of a block."""


@dataclass(frozen=True, kw_only=True, slots=True)
class SeriesPlan:
    """A series of as many maps as the recipe has, of difficulty `from_` to `to` in equal steps.

    Their target rms steps lie on a straight line: difficulty * the mean rms step of all their fields as designed. So a
    field that is rougher than others is flattened more, and one that is less rough less. by, robot: another metric that
    rises so, from the mean of the level fields to the mean of the fields as designed.
    """

    recipe: Recipe
    from_: From = 0.1
    to: To = 1.0
    same_field: SameField = False
    by: By = RMS
    robot: CrossingModel | None = None

    def __post_init__(self) -> None:
        validate(self)
        if self.from_ > self.to:
            raise ParameterError("from", f"{shown(self.from_)} is above to, {shown(self.to)}; a series rises")
        if self.recipe.maps < 2:
            raise ParameterError("maps", f"{self.recipe.maps} map is not a series; use 2 or more")
        if self.recipe.difficulty != 1:
            difficulty = shown(self.recipe.difficulty)
            raise ParameterError("difficulty", f"{difficulty} is for maps of one difficulty; use from and to instead")
        self.whole(self.recipe.maps - 1)  # refuses a name that is too long with the number
        _ = self.metric  # refuses an unknown metric

    @property
    def metric(self) -> Metric:
        """The metric that rises from map to map."""
        return metric_by(self.by, self.robot)

    @property
    def fields(self) -> range:
        """The number of one map for each different field."""
        return range(1 if self.same_field else self.recipe.maps)

    def difficulty(self, number: int) -> float:
        """Return the difficulty of map `number`, counted from 0, with the mean of the fields as 1."""
        return round(self.from_ + (self.to - self.from_) * number / (self.recipe.maps - 1), DIGITS)

    def whole(self, number: int) -> Recipe:
        """Return the recipe of map `number` and no other, at difficulty 1.

        Maps of one field have the same index, which seeds their random draws; so the recipe's name has their number.
        """
        if self.same_field:
            return replace(self.recipe, name=f"{self.recipe.name}-{number:04d}", maps=1)
        return self.recipe.alone(self.recipe.first_map + number)

    def map_name(self, number: int) -> str:
        """Return the name of map `number`."""
        recipe = self.recipe
        if self.same_field:
            return f"{recipe.name}-{number:04d}_{recipe.first_map:04d}"
        return recipe.map_name(recipe.first_map + number)


class MapTarget(NamedTuple):
    """A map's recipe, the value of the metric of its field as designed, and the value that it should have."""

    recipe: Recipe
    full: float | None
    asked: float


def span(plan: SeriesPlan, number: int) -> Span:
    """Return the metric of the field of map `number`, level and as designed; 0 for the rms step of no steps."""
    whole = plan.whole(number)
    return Span(0.0, _rms(whole) or 0.0) if plan.by == RMS else span_of(whole, whole.first_map, plan.metric)


def mean(plan: SeriesPlan, spans: Sequence[Span]) -> Span:
    """Return the values from which and to which a series rises; ParameterError if a metric does not rise."""
    if plan.by == RMS:
        return Span(0.0, fsum(field.full for field in spans) / len(spans))
    return mean_span(spans, plan.metric.name)


def map_target(plan: SeriesPlan, number: int, line: Span) -> MapTarget:
    """Return the target of map `number` on the line from level to as designed; at most its field as designed."""
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
    """Return the difficulty at which a map has this rms step; searched for if constraints lower the steps further."""
    if rms >= full or not whole.is_constrained:
        return min(rms / full, 1.0)
    return bisected(lambda share: (_rms(replace(whole, difficulty=share)) or 0.0) >= rms)[1]


def _rms(recipe: Recipe) -> float | None:
    return steps(build(recipe, recipe.first_map)).rms


@dataclass(frozen=True, kw_only=True, slots=True)
class SeriesRow:
    """The row of one map; a value that does not exist, such as the steps of a single block, is None.

    difficulty: its place between the first and the last   rms_asked: difficulty * the mean rms_full of all maps
    rms: the rms step that it has   rms_full: of its field as designed   recipe_difficulty: what its recipe has
    highest_step: between neighbouring blocks   opening_...: the climb at which it opens   mean_height: of its blocks
    asked, measured, full: of the metric by which the series rises, as rms_asked, rms and rms_full of the rms step; by
    another metric there is no rms_asked and no rms_full
    """

    number: int
    map: str
    difficulty: float
    rms_asked: float | None
    rms: float | None
    rms_full: float | None
    recipe_difficulty: float
    highest_step: float | None
    opening_west_east: float
    opening_south_north: float
    mean_height: float
    asked: float | None
    measured: float | None
    full: float | None


def series_row(plan: SeriesPlan, number: int, scene: Scene, target: MapTarget) -> SeriesRow:
    """Return the row of map `number`, with its target."""
    # Columns of the rms step are always there, as users' scripts read them; those of another metric are empty without
    # it.
    own, ways, by_rms = steps(scene.field), percolation(scene.field), plan.by == RMS
    measured = own.rms if by_rms else plan.metric(scene.field)
    asked = None if by_rms and own.rms is None else _rounded(target.asked)
    return SeriesRow(
        number=number,
        map=scene.name,
        difficulty=plan.difficulty(number),
        rms_asked=asked if by_rms else None,
        rms=_rounded(own.rms),
        rms_full=_rounded(target.full) if by_rms else None,
        recipe_difficulty=scene.recipe.difficulty_of(scene.index),
        highest_step=_rounded(own.highest),
        opening_west_east=ways.west_east,
        opening_south_north=ways.south_north,
        mean_height=round(spread(scene.field).mean, NANOMETRE_DIGITS),
        asked=asked,
        measured=_rounded(measured),
        full=_rounded(target.full),
    )


def rows_as_csv(rows: Sequence[SeriesRow]) -> bytes:
    """Return the rows as the content of a CSV file; None is an empty cell."""
    stream = io.StringIO()
    writer = csv.DictWriter(stream, [field.name for field in fields(SeriesRow)], lineterminator="\n")
    writer.writeheader()
    writer.writerows(map(asdict, rows))
    return stream.getvalue().encode()


def _rounded(value: float | None) -> float | None:
    return None if value is None or isnan(value) else round(value, NANOMETRE_DIGITS)
