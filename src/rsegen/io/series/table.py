"""The rows of series.csv: what each map of a series should measure, and what it measures; lengths in metres."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields

from rsegen.exporters.scene import Scene
from rsegen.field.metrics.percolation import percolation
from rsegen.field.metrics.spread import spread
from rsegen.field.metrics.steps import steps
from rsegen.field.stepfield import NANOMETRE_DIGITS


@dataclass(frozen=True, kw_only=True, slots=True)
class SeriesRow:
    """The row of one map; a value that does not exist, such as the steps of a single block, is None.

    difficulty: its place between the first and the last   rms_asked: difficulty * the mean rms_full of all maps
    rms: the rms step that it has   rms_full: that of its field as designed   recipe_difficulty: that of its recipe
    highest_step: between neighbouring blocks   opening_...: the climb at which it opens   mean_height: of its blocks
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


def series_row(number: int, difficulty: float, scene: Scene, rms_asked: float, full: float | None) -> SeriesRow:
    """The row of map `number`, with its target and the rms step of its field as designed."""
    own, ways = steps(scene.field), percolation(scene.field)
    return SeriesRow(
        number=number,
        map=scene.name,
        difficulty=difficulty,
        rms_asked=None if own.rms is None else _rounded(rms_asked),
        rms=_rounded(own.rms),
        rms_full=_rounded(full),
        recipe_difficulty=scene.recipe.difficulty_of(scene.index),
        highest_step=_rounded(own.highest),
        opening_west_east=ways.west_east,
        opening_south_north=ways.south_north,
        mean_height=round(spread(scene.field).mean, NANOMETRE_DIGITS),
    )


def rows_as_csv(rows: Sequence[SeriesRow]) -> bytes:
    """The rows as the content of a CSV file; None is an empty cell."""
    stream = io.StringIO()
    writer = csv.DictWriter(stream, [field.name for field in fields(SeriesRow)], lineterminator="\n")
    writer.writeheader()
    writer.writerows(map(asdict, rows))
    return stream.getvalue().encode()


def _rounded(value: float | None) -> float | None:
    return None if value is None else round(value, NANOMETRE_DIGITS)
