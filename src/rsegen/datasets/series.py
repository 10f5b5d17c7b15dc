"""Write a series: its maps, a table of what they measure, and a chart of how they rise.

    recipe --plan_series: measures all fields as designed--> SeriesRun --run--> rows and maps --> Series

Maps that exist are measured again for their rows, so that table and chart have all of them.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import prod
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from rsegen.datasets.difficulty_tiles import HALVINGS, Span
from rsegen.datasets.series_rows import SeriesPlan, SeriesRow, map_target, mean, rows_as_csv, series_row, span
from rsegen.field.stepfield import Array
from rsegen.measuring.catalogue import RMS
from rsegen.params.numbers import lengths_in
from rsegen.params.watch import report_share
from rsegen.pictures.plan import draw_cells, legend_swatches
from rsegen.pictures.preview import encoded
from rsegen.recipe.codec import map_json, to_json
from rsegen.recipe.recipe import Recipe
from rsegen.scene.scene import Scene, compose
from rsegen.writing.execute import Execution, execute
from rsegen.writing.plan import OnExisting, Output, RunPlan, is_kept, run_in
from rsegen.writing.sidecars import Sidecar, are_complete
from rsegen.writing.store import open_store, refuse_busy
from rsegen.writing.worlds import GeneratedMap, refuse_names, seconds_per_world, world_output, worlds_at_once

if TYPE_CHECKING:
    from matplotlib.axes import Axes

TABLE, PICTURE = "series.csv", "series.png"


@dataclass(frozen=True, kw_only=True, slots=True)
class Series:
    """A series on disk.

    Attributes
    ----------
    plan : SeriesPlan
        What was to be made.
    folder : Path
        The folder that it is in.
    rows : tuple of SeriesRow
        What each map measures, in their order.
    maps : tuple of GeneratedMap
        Those that were made; the others existed already.
    """

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
    plan: SeriesPlan,
    folder: Path,
    sidecars: Sequence[Sidecar],
    on_existing: OnExisting,
    execution: Execution | None = None,
) -> SeriesRun:
    """Check that a series can be made in a folder, measure its fields, and plan it; nothing is written."""
    execution, numbers = execution or Execution(), range(plan.recipe.maps)
    refuse_busy(folder)
    at_once = worlds_at_once(plan.recipe, len(numbers), folder, sidecars, "measure")
    execution = replace(execution, workers=min(execution.workers, at_once))
    if callable(plan.by):  # a function of the caller, which another process may not have
        execution = Execution(sync=execution.sync)
    refuse_names(folder, map(plan.map_name, numbers), (TABLE, PICTURE), on_existing)
    # The line on which a series rises follows from all of its fields, so these are measured before the first map.
    spans: list[Span] = []
    for batch in execute(partial(_spans, plan), plan.fields, 2 * _seconds_per_value(plan), execution):
        spans += batch
        report_share("fields as designed", len(spans) / len(plan.fields))
    line = mean(plan, spans)
    keeps = on_existing is OnExisting.KEEP
    existing = _existing(plan, line, folder, sidecars) if keeps else []
    searched = 0 if plan.by == RMS else HALVINGS * _seconds_per_value(plan)
    return RunPlan(
        folder=folder,
        product=partial(_map, plan, folder, sidecars, line, frozenset(existing) if keeps else None),
        # A world, 3 ms and 1 us per cell for its row, and a search for its share: estimates, as in `seconds_per_world`.
        seconds=seconds_per_world(plan.recipe, sidecars) + 3e-3 + prod(plan.recipe.grid.shape) * 1e-6 + searched,
        to_make=numbers,
        existing=existing,
        replaces=on_existing is not OnExisting.REFUSE,
        execution=execution,
    )


def _existing(plan: SeriesPlan, line: Span, folder: Path, sidecars: Sequence[Sidecar]) -> list[int]:
    """Return the numbers of the maps that are complete; an OutputError if something else has the name of a map."""
    homes = ((number, folder / plan.map_name(number)) for number in range(plan.recipe.maps))
    return [
        number
        for number, home in homes
        if os.path.lexists(home)
        and is_kept(home, _recipe_file(map_target(plan, number, line).recipe), partial(are_complete, sidecars))
    ]


def _recipe_file(recipe: Recipe) -> bytes:
    """Return the recipe.json of the one map of a recipe."""
    return map_json(recipe, recipe.first_map)


def _seconds_per_value(plan: SeriesPlan) -> float:
    """Return about how long a field is made and its metric measured, an estimate as in `seconds_per_world`."""
    cells = prod(plan.recipe.grid.shape)
    if plan.by == RMS:
        return 7e-5 + cells * 1.5e-8
    return 0.2 if plan.robot is not None else 1e-3 + cells * 1.5e-6  # a robot looks for its ways


def _spans(plan: SeriesPlan, numbers: Iterable[int]) -> tuple[Span, ...]:
    """Measure fields of a series, level and as designed."""
    return tuple(span(plan, number) for number in numbers)


def _map(
    plan: SeriesPlan,
    folder: Path,
    sidecars: Sequence[Sidecar],
    line: Span,
    existing: frozenset[int] | None,
    number: int,
) -> Output[RowAndMap]:
    """Return the row and the files of a map on a line by its number; an existing one is measured only, for its row.

    existing: the numbers of maps that are complete and kept, as are files of incomplete ones; None if none are
    """
    target = map_target(plan, number, line)
    scene = compose(target.recipe, target.recipe.first_map)
    row = series_row(plan, number, scene, target)
    if number in (existing or ()):
        return Output(made=(row, None), folder=plan.map_name(number))
    world = world_output(scene, folder, sidecars, keeps_files=existing is not None)
    return Output(made=(row, world.made), files=world.files, folder=world.folder)


# The chart.


_PLANS = 8
"""Plans that are drawn at most, evenly spaced: as many as are still large enough to be seen next to each other."""

_SWATCHES = 12
"""Heights in the legend at most, which has one line."""

_INK, _LINE, _PALE = "#2b2b33", "#d6336c", "#a9a9b5"


def _chart(plan: SeriesPlan, rows: Sequence[SeriesRow]) -> bytes:
    """Return a PNG of the metric of every map and plans of some of them; it carries the recipe at difficulty 1."""
    from matplotlib.figure import Figure

    shown = np.unique(np.rint(np.linspace(0, len(rows) - 1, _PLANS))).astype(int).tolist()  # the first and the last too
    drawn = [replace(plan.whole(number), difficulty=rows[number].recipe_difficulty) for number in shown]
    scenes = [compose(recipe, recipe.first_map) for recipe in drawn]
    figure = Figure(figsize=(13, 7.4), dpi=100, layout="constrained")
    grid = figure.add_gridspec(2, len(shown), height_ratios=(2.6, 1))
    _draw_rise(figure.add_subplot(grid[0, :]), plan, rows, shown)
    for column, scene in enumerate(scenes):
        _draw_plan(figure.add_subplot(grid[1, column]), plan, scene, rows[shown[column]])
    handles = legend_swatches(scenes[0], _SWATCHES, {level for scene in scenes for level in scene.field.level_counts()})
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), frameon=False)
    fields = "one field" if plan.same_field else f"{len(rows)} fields"
    figure.suptitle(f"{plan.recipe.name}: {fields}, difficulty {plan.from_:g} to {plan.to:g}, seed {plan.recipe.seed}")
    return encoded(figure, "png", to_json(plan.recipe))


def _draw_rise(axes: Axes, plan: SeriesPlan, rows: Sequence[SeriesRow], shown: Sequence[int]) -> None:
    from matplotlib.ticker import MaxNLocator

    # Asked for as a line, reached as points on it, what a field cannot reach as a gap between both.
    numbers = np.array([row.number for row in rows])
    asked, reached, full = (_column(plan, rows, name) for name in ("asked", "measured", "full"))
    share = f"difficulty x {np.nan_to_num(full).mean():.3g} {_unit(plan)}"
    if plan.by != RMS:
        line = f"from level to as designed{'' if plan.same_field else ', in the mean of the fields'}"
    elif plan.same_field:
        line = f"{share}, the rms step of the field as it is"
    else:
        line = f"{share}, the mean rms step of the fields as they are"
    axes.plot(numbers, asked, color=_LINE, linewidth=2, label=f"asked for: {line}")
    if not plan.same_field:
        axes.plot(numbers, full, "_", color=_PALE, markersize=9, label="the field as it is: it gets no harder")
    axes.vlines(numbers, asked, reached, color=_INK, linewidth=1)
    size = float(np.clip(260 / len(rows), 2, 7))  # points of hundreds of maps do not overlap
    axes.plot(numbers, reached, "o", color=_INK, markersize=size, label="reached", zorder=3)
    marked = np.isin(numbers, shown)
    axes.plot(numbers[marked], reached[marked], "o", color="white", markersize=size * 0.45, zorder=4)
    unit = f" [{_unit(plan)}]" if _unit(plan) else ""
    name = "rms step between neighbouring blocks" if plan.by == RMS else plan.metric.name
    axes.set(xlabel="map (light in the middle: its plan is below)", ylabel=f"{name}{unit}")
    if plan.by == RMS:
        axes.set_ylim(bottom=0)
    axes.margins(x=0.02)
    axes.grid(visible=True, alpha=0.25)
    axes.spines[["top", "right"]].set_visible(False)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.legend(frameon=False, loc="lower right")


def _unit(plan: SeriesPlan) -> str:
    """Return the unit of the metric; lengths are shown in the recipe's units."""
    return lengths_in(plan.recipe.units).unit if plan.metric.unit == "m" else plan.metric.unit


def _column(plan: SeriesPlan, rows: Sequence[SeriesRow], name: str) -> Array:
    """Return a column of the table, as it is shown; NaN for values that do not exist."""
    cells = (getattr(row, name) for row in rows)
    values = np.array([np.nan if value is None else value for value in cells], dtype=float)
    return values * lengths_in(plan.recipe.units).per_metre if plan.metric.unit == "m" else values


def _draw_plan(axes: Axes, plan: SeriesPlan, scene: Scene, row: SeriesRow) -> None:
    draw_cells(axes, scene)
    (value,) = _column(plan, [row], "measured")
    reached = "" if row.measured is None else f"\n{value:.3g} {_unit(plan)}"
    axes.set_title(f"{row.number}: difficulty {row.difficulty:.3g}{reached}", fontsize=9, color=_INK)
    axes.set(xticks=[], yticks=[])
    for spine in axes.spines.values():
        spine.set(color=_INK, linewidth=0.5)
