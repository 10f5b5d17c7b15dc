"""The rows of series.csv: what each map of a series should measure, and what it measures; lengths in metres."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from math import isnan

from rsegen.exporters.scene import Scene
from rsegen.field.metrics.by_name import RMS
from rsegen.field.metrics.percolation import percolation
from rsegen.field.metrics.spread import spread
from rsegen.field.metrics.steps import steps
from rsegen.field.stepfield import NANOMETRE_DIGITS
from rsegen.run.series.plan import SeriesPlan
from rsegen.run.series.target import MapTarget


@dataclass(frozen=True, kw_only=True, slots=True)
class SeriesRow:
    """The row of one map; a value that does not exist, such as the steps of a single block, is None.

    difficulty: its place between the first and the last   rms_asked: difficulty * the mean rms_full of all maps
    rms: the rms step that it has   rms_full: that of its field as designed   recipe_difficulty: that of its recipe
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
    """The row of map `number`, with its target."""
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
    """The rows as the content of a CSV file; None is an empty cell."""
    stream = io.StringIO()
    writer = csv.DictWriter(stream, [field.name for field in fields(SeriesRow)], lineterminator="\n")
    writer.writeheader()
    writer.writerows(map(asdict, rows))
    return stream.getvalue().encode()


def _rounded(value: float | None) -> float | None:
    return None if value is None or isnan(value) else round(value, NANOMETRE_DIGITS)
