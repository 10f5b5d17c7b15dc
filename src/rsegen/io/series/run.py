"""A series on disk: its maps, a table of what they measure, and a picture of how they rise."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from math import prod
from pathlib import Path

from rsegen.errors import ParameterError
from rsegen.exporters.formats import Format
from rsegen.exporters.scene import compose
from rsegen.io.existing import is_complete
from rsegen.io.resources import (
    BYTES_PER_CELL_OF_DIFFICULTY,
    BYTES_PER_CELL_OF_METRICS,
    maps_in_memory,
    refuse_too_large,
    refuse_too_many,
)
from rsegen.io.series.plan import SeriesPlan
from rsegen.io.series.table import SeriesRow, rows_as_csv, series_row
from rsegen.io.series.target import map_target, mean, rms_full
from rsegen.io.sidecars import Sidecars
from rsegen.io.work import WORKERS, run_each, run_in_order
from rsegen.io.worlds import GeneratedMap, made, seconds
from rsegen.io.writer import refuse_not_a_folder, refuse_taken, refuse_taken_file, remove_leftovers, write_file
from rsegen.recipe.codec import to_json
from rsegen.recipe.recipe import Recipe

TABLE, PICTURE = "series.csv", "series.png"
_BYTES_PER_CELL = BYTES_PER_CELL_OF_METRICS + BYTES_PER_CELL_OF_DIFFICULTY


@dataclass(frozen=True, kw_only=True, slots=True)
class Series:
    """A series on disk: a row for each map; `maps` are those that were made, the others were there already."""

    plan: SeriesPlan
    folder: Path
    rows: tuple[SeriesRow, ...]
    maps: tuple[GeneratedMap, ...]

    @property
    def table(self) -> Path:
        """The file of the rows."""
        return self.folder / TABLE

    @property
    def picture(self) -> Path:
        """The measure over the maps, and plans of some of them."""
        return self.folder / PICTURE


def series(  # noqa: PLR0913  # each is a flag of the command
    recipe: Recipe,
    folder: str | Path,
    *,
    maps: int | None = None,
    from_: float = 0.1,
    to: float = 1.0,
    same_field: bool = False,
    force: bool = False,
    resume: bool = False,
    preview: bool = False,
    sheet: bool = False,
    formats: Sequence[Format] = (),
    workers: int = 1,
    progress: Callable[[SeriesRow], None] | None = None,
) -> Series:
    """Write maps of evenly rising difficulty, series.csv and series.png into a folder; as many as the recipe has.

    With `same_field` all are one field, else each is a new one. The rest is as in `generate`; `progress` is told of
    each map that is done. Table and picture come last, whole or not at all.
    """
    folder, workers = Path(folder), WORKERS.check("workers", workers)
    if force and resume:
        raise ParameterError("resume", "--resume and --force exclude each other")
    plan = SeriesPlan(
        recipe=recipe if maps is None else replace(recipe, maps=maps), from_=from_, to=to, same_field=same_field
    )
    extras = Sidecars(preview=preview, sheet=sheet, formats=tuple(formats))
    extras.refuse(plan.recipe)
    refuse_too_large(plan.recipe, _BYTES_PER_CELL + extras.bytes_a_cell)
    refuse_not_a_folder(folder)
    refuse_too_many(plan.recipe.maps, folder)
    work = _Work(plan=plan, folder=folder, replace=force or resume, extras=extras, resume=resume)
    work = _ready(work, workers)
    found = run_in_order(work, work.numbers, workers, progress and (lambda done: progress(done[0])))
    rows, made_ones = tuple(row for row, _ in found), tuple(one for _, one in found if one)
    _write_both(plan, rows, folder, force=force or resume)
    return Series(plan=plan, folder=folder, rows=rows, maps=made_ones)


@dataclass(frozen=True, kw_only=True, slots=True)
class _Fields:
    """What the fields of a series measure as they are."""

    plan: SeriesPlan

    @property
    def seconds(self) -> float:
        return 1.5e-4 + prod(self.plan.recipe.grid.shape) * 3e-8

    @property
    def at_once(self) -> int:
        return maps_in_memory(self.plan.recipe, _BYTES_PER_CELL)

    def __call__(self, numbers: Iterable[int], /) -> tuple[float | None, ...]:
        return tuple(rms_full(self.plan, number) for number in numbers)


Done = tuple[SeriesRow, GeneratedMap | None]
"""A map's row, and the map itself where it was made."""


@dataclass(frozen=True, kw_only=True, slots=True)
class _Work:
    """What a worker is told; `mean` is the rms step of difficulty 1, metres."""

    plan: SeriesPlan
    folder: Path
    replace: bool
    extras: Sidecars
    resume: bool
    mean: float = 0.0

    @property
    def numbers(self) -> range:
        return range(self.plan.recipe.maps)

    @property
    def seconds(self) -> float:
        n_x, n_y = self.plan.recipe.grid.shape
        return seconds(self.plan.recipe, self.extras) + 3e-3 + n_x * n_y * 1e-6

    @property
    def at_once(self) -> int:
        return maps_in_memory(self.plan.recipe, _BYTES_PER_CELL + self.extras.bytes_a_cell)

    def home(self, number: int) -> Path:
        return self.folder / self.map_name(number)

    def map_name(self, number: int) -> str:
        return self.plan.map_name(number)

    def __call__(self, numbers: Iterable[int], /) -> tuple[Done, ...]:
        return tuple(map(self.done, numbers))

    def done(self, number: int) -> Done:
        on_line = map_target(self.plan, number, self.mean)
        scene = compose(on_line.recipe, on_line.recipe.first_map)
        there = self.stands(number, on_line.recipe)
        one = None if there else made(scene, self.folder, self.extras, replace=self.replace)
        return series_row(number, self.plan.difficulty(number), scene, on_line.rms, on_line.full), one

    def refuse_others(self) -> None:
        """Raise an OutputError where something else than its map has a map's name."""
        for number in (number for number in self.numbers if os.path.lexists(self.home(number))):
            self.stands(number, map_target(self.plan, number, self.mean).recipe)

    def stands(self, number: int, recipe: Recipe) -> bool:
        """Whether the map of that recipe is there already, where that is asked; an OutputError where it is another."""
        home = self.home(number)
        if not (self.resume and os.path.lexists(home)):
            return False
        return is_complete(str(home), to_json(recipe).encode(), self.extras.stand)


def _ready(work: _Work, workers: int) -> _Work:
    """The same with its mean, and nothing in its way."""
    for name in (TABLE, PICTURE):
        refuse_taken_file(work.folder / name, force=work.replace)
    if not work.resume:
        refuse_taken(map(work.home, work.numbers), force=work.replace)
    work = replace(work, mean=mean(tuple(run_each(_Fields(plan=work.plan), work.plan.fields, workers))))
    if work.resume:
        work.refuse_others()
        remove_leftovers(work.folder, lambda name: name in map(work.map_name, work.numbers))
    return work


def _write_both(plan: SeriesPlan, rows: tuple[SeriesRow, ...], folder: Path, *, force: bool) -> None:
    from rsegen.io.series.chart import chart

    content = {TABLE: rows_as_csv(rows), PICTURE: chart(plan, rows)}
    for name, whole in content.items():
        write_file([whole], folder / name, force=force)
