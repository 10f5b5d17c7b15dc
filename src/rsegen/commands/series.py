"""`rsegen series`: maps whose difficulty rises evenly."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from rsegen.commands.parameters import (
    By,
    ByRobot,
    Force,
    Formats,
    OutputFolder,
    Preview,
    Resume,
    Scheduler,
    Sheet,
    Sync,
    Workers,
)
from rsegen.params.command import Shell, command
from rsegen.params.sorts import Flag, Float

if TYPE_CHECKING:
    from rsegen.recipe.recipe import Recipe
    from rsegen.run.series import Series
    from rsegen.run.series_rows import SeriesRow


@command
def series(  # noqa: PLR0913  # each is a flag
    recipe: Recipe,
    folder: OutputFolder,
    *,
    maps: int | None = None,
    from_: Annotated[float, Float(0, 1, help="difficulty of the first map"), Shell(("--from",), "D")] = 0.1,
    to: Annotated[float, Float(0, 1, help="difficulty of the last map"), Shell(metavar="D")] = 1.0,
    same_field: Annotated[bool, Flag(help="one field at rising difficulty; else every map is another field")] = False,
    by: By = "steps.rms",
    robot: ByRobot = None,
    force: Force = False,
    resume: Resume = False,
    preview: Preview = False,
    sheet: Sheet = False,
    formats: Formats = (),
    workers: Workers = 1,
    scheduler: Scheduler = None,
    sync: Sync = True,
    progress: Callable[[SeriesRow], None] | None = None,
) -> Series:
    """Write maps of evenly rising difficulty, a table of what they measure (series.csv) and a picture (series.png).

    maps: their number, by default that of the recipe. by: the metric that rises evenly, by its name or as a function
    StepField -> float, which is called in this process alone. progress: called with the row of each map that is done.
    Table and picture come last, whole or not at all. The rest, and the errors, are as in `generate`.
    """
    from dataclasses import replace

    from rsegen.run.execute import Execution
    from rsegen.run.plan import OnExisting
    from rsegen.run.series import make_series, plan_series
    from rsegen.run.series_rows import SeriesPlan
    from rsegen.run.worlds import Sidecars

    recipe = recipe if maps is None else replace(recipe, maps=maps)
    series_plan = SeriesPlan(recipe=recipe, from_=from_, to=to, same_field=same_field, by=by, robot=robot)  # type: ignore[arg-type]  # checked
    sidecars = Sidecars(preview=preview, sheet=sheet, formats=formats)
    execution = Execution(workers=workers, scheduler=scheduler, sync=sync)
    plan = plan_series(series_plan, Path(folder), sidecars, OnExisting.of(force=force, resume=resume), execution)
    return make_series(series_plan, plan, progress)
