"""Write a series: its maps, a table of what they measure, and a chart of how they rise.

    recipe --plan_series: measures all fields as designed--> SeriesRun --run--> rows and maps --> Series

Maps that exist are measured again for their rows, so that table and chart are those of all.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from math import prod
from pathlib import Path

from rsegen.exporters.scene import compose
from rsegen.io.resources import check_needs
from rsegen.recipe.codec import to_json
from rsegen.recipe.tiles import Span
from rsegen.run.execute import Execution, execute
from rsegen.run.journal import read_journal
from rsegen.run.plan import OnExisting, Output, RunPlan, is_kept, run_in
from rsegen.run.series_rows import SeriesPlan, SeriesRow, map_target, mean, rows_as_csv, series_row, span
from rsegen.run.store import open_store, refuse_busy, refuse_taken, refuse_taken_file
from rsegen.run.worlds import GeneratedMap, Sidecars, seconds_per_world, world_output

TABLE, PICTURE = "series.csv", "series.png"


@dataclass(frozen=True, kw_only=True, slots=True)
class Series:
    """A series on disk: a row for each map; `maps` are those that were made, the others existed already."""

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
        """The chart: the metric over the maps, and plans of some of them."""
        return self.folder / PICTURE


def make_series(
    series_plan: SeriesPlan, plan: SeriesRun, progress: Callable[[SeriesRow], None] | None = None
) -> Series:
    """Make the maps of a planned series, then its table and its picture; `progress` is called with each map's row."""
    with open_store(plan.folder, sync=plan.execution.sync) as store:
        results = run_in(store, plan, progress and (lambda result: progress(result[0])))
        rows, made = tuple(row for row, _ in results), tuple(made for _, made in results if made)
        store.put({TABLE: [rows_as_csv(rows)], PICTURE: [_chart(series_plan, rows)]}, force=plan.replaces)
    return Series(plan=series_plan, folder=plan.folder, rows=rows, maps=made)


RowAndMap = tuple[SeriesRow, GeneratedMap | None]
"""The row of a map, and the map itself if it was made."""

SeriesRun = RunPlan[int, RowAndMap]
"""The plan of a run that makes a series; its items are the numbers of maps, which are all measured for their rows."""


def plan_series(
    plan: SeriesPlan, folder: Path, sidecars: Sidecars, on_existing: OnExisting, execution: Execution | None = None
) -> SeriesRun:
    """Check that a series can be made in a folder, measure its fields, and plan it; nothing is written."""
    execution, numbers = execution or Execution(), range(plan.recipe.maps)
    sidecars.refuse(plan.recipe)
    refuse_busy(folder)
    needs = check_needs([plan.recipe], len(numbers), folder, "measure", sidecars.formats)
    execution = replace(execution, workers=min(execution.workers, needs.maps_at_once))
    if callable(plan.by):  # a function of the caller, which another process may not have
        execution = Execution(sync=execution.sync)
    replaces, keeps = on_existing is not OnExisting.REFUSE, on_existing is OnExisting.KEEP
    read_journal(folder)  # which will list both
    for name in (TABLE, PICTURE):
        refuse_taken_file(folder / name, force=replaces)
    if not keeps:
        refuse_taken((folder / plan.map_name(number) for number in numbers), force=replaces)
    measure = _Fields(plan=plan)
    spans = execute(measure, plan.fields, measure.seconds, execution)
    line = mean(plan, [field for batch in spans for field in batch])
    existing = _existing(plan, line, folder, sidecars) if keeps else []
    return RunPlan(
        folder=folder,
        product=_Maps(plan=plan, folder=folder, sidecars=sidecars, line=line, existing=frozenset(existing)),
        to_make=numbers,
        existing=existing,
        replaces=replaces,
        execution=execution,
    )


def _existing(plan: SeriesPlan, line: Span, folder: Path, sidecars: Sidecars) -> list[int]:
    """Return the numbers of the maps that are complete; an OutputError if something else has the name of a map."""
    complete = []
    for number in range(plan.recipe.maps):
        home = folder / plan.map_name(number)
        if not os.path.lexists(home):
            continue
        if is_kept(home, to_json(map_target(plan, number, line).recipe).encode(), sidecars.complete_in):
            complete.append(number)
    return complete


@dataclass(frozen=True, kw_only=True, slots=True)
class _Fields:
    """A task that measures the fields of a series as designed."""

    plan: SeriesPlan

    @property
    def seconds(self) -> float:
        return 1.5e-4 + prod(self.plan.recipe.grid.shape) * 3e-8  # an estimate, as in `seconds_per_world`

    def __call__(self, numbers: Iterable[int], /) -> tuple[Span, ...]:
        return tuple(span(self.plan, number) for number in numbers)


@dataclass(frozen=True, kw_only=True, slots=True)
class _Maps:
    """A product that makes and measures maps by their numbers; existing ones are measured only, for their rows.

    line: the values from which and to which they rise
    """

    plan: SeriesPlan
    folder: Path
    sidecars: Sidecars
    line: Span
    existing: frozenset[int]

    @property
    def seconds(self) -> float:
        n_x, n_y = self.plan.recipe.grid.shape
        # Estimates, as in `seconds_per_world`: a world, and 3 ms and 1 us per cell for its row.
        return seconds_per_world(self.plan.recipe, self.sidecars) + 3e-3 + n_x * n_y * 1e-6

    def __call__(self, number: int, /) -> Output[RowAndMap]:
        target = map_target(self.plan, number, self.line)
        scene = compose(target.recipe, target.recipe.first_map)
        row = series_row(self.plan, number, scene, target)
        if number in self.existing:
            return Output(made=(row, None))
        world = world_output(scene, self.folder, self.sidecars)
        return Output(made=(row, world.made), files=world.files, folder=world.folder)


def _chart(plan: SeriesPlan, rows: tuple[SeriesRow, ...]) -> bytes:
    from rsegen.run.series_chart import chart  # which imports matplotlib

    return chart(plan, rows)
