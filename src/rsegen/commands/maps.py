"""Commands that write maps: `rsegen generate`, `series`, `dataset` and `export`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from rsegen.commands.parameters import (
    By,
    ByRobot,
    Force,
    FormatList,
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
from rsegen.params.sorts import Choice, FilePath, Flag, Float, Integer, Reference
from rsegen.params.streams import SEEDS

if TYPE_CHECKING:
    from rsegen.exporters.formats import Format
    from rsegen.exporters.scene import Scene
    from rsegen.io.dataset.reading import Dataset
    from rsegen.recipe.recipe import Recipe
    from rsegen.run.dataset import Progress
    from rsegen.run.exports import Exported, ExportedMap
    from rsegen.run.series import Series
    from rsegen.run.series_rows import SeriesRow
    from rsegen.run.worlds import Generated, GeneratedMap


@command
def generate(  # noqa: PLR0913  # each is a flag
    recipe: Recipe,
    folder: OutputFolder,
    *,
    force: Force = False,
    resume: Resume = False,
    preview: Preview = False,
    sheet: Sheet = False,
    formats: Formats = (),
    workers: Workers = 1,
    scheduler: Scheduler = None,
    sync: Sync = True,
    progress: Callable[[GeneratedMap], None] | None = None,
    beside: Mapping[str, Callable[[], bytes]] | None = None,
) -> Generated:
    """Write the maps of a recipe as Gazebo worlds and models: folder/NAME_0000, folder/NAME_0001, ...

    With more than one worker a script needs `if __name__ == "__main__":`.

    Parameters
    ----------
    recipe : Recipe
        The maps.
    progress : callable, optional
        Called with each map that is done, in their order.
    beside : mapping of str to callable, optional
        What makes the content of files next to the maps, by their names; called once nothing refuses the run.

    Returns
    -------
    Generated
        The maps on disk.

    Raises
    ------
    OutputError
        Before anything is written, if a map's folder is taken or has files that rsegen did not write.
    TooLarge
        Before anything is written, if memory or disk space are too small.
    ParameterError
        Before anything is written, if maps are too large for build sheets.
    """
    from rsegen.run.execute import Execution
    from rsegen.run.plan import OnExisting
    from rsegen.run.worlds import Sidecars, make_worlds, plan_worlds

    sidecars = Sidecars(preview=preview, sheet=sheet, formats=formats)
    execution = Execution(workers=workers, scheduler=scheduler, sync=sync)
    plan = plan_worlds(
        recipe, Path(folder), sidecars, OnExisting.of(force=force, resume=resume), execution, beside=beside or ()
    )
    # What lies beside the maps may take long to make, so it is made once nothing refuses the run.
    files = {name: make() for name, make in (beside or {}).items()}
    return make_worlds(recipe, plan, progress, files)


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

    Table and picture come last, whole or not at all. In Python `by` may be a function StepField -> float too, which is
    called in this process alone. Errors are as in `generate`.

    Parameters
    ----------
    recipe : Recipe
        The maps.
    maps : int, optional
        Their number; by default that of the recipe.
    progress : callable, optional
        Called with the row of each map that is done.

    Returns
    -------
    Series
        The maps on disk, and what they measure.
    """
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


@command
def make_dataset(  # noqa: PLR0913  # each is a flag
    recipe: Recipe | Sequence[Recipe],
    folder: OutputFolder,
    *,
    metrics: Annotated[
        str, Choice(("npy", "parquet", "none"), help="form of the table of metrics; parquet needs rsegen[dataset]")
    ] = "npy",
    shard_maps: Annotated[int, Integer(0, 10**9, unit="maps", help="maps per file; 0: about a million cells")] = 0,
    force: Force = False,
    resume: Resume = False,
    workers: Workers = 1,
    scheduler: Scheduler = None,
    sync: Sync = True,
    progress: Progress | None = None,
) -> Dataset:
    """Write the maps of one or several recipes as a data set: block levels as arrays, metrics as tables, in shards.

    `force` replaces a data set in one step once the new one is complete. With more than one worker a script needs
    `if __name__ == "__main__":`.

    Parameters
    ----------
    recipe : Recipe or sequence of Recipe
        The maps. Several recipes have different names, and maps of one size, unit, width of blocks and boundary.
    progress : callable, optional
        Called with the number of maps that are done since the last call, and whether they existed `already`.

    Returns
    -------
    Dataset
        The data set on disk.

    Raises
    ------
    ParameterError
        If the recipes do not go together.
    OutputError
        Before anything is written, if the folder holds something else.
    TooLarge
        If there is too little space.
    """
    from rsegen.io.dataset.layout import ShardLayout
    from rsegen.recipe.tiles import recipes_of
    from rsegen.run.dataset import make_shards, plan_dataset
    from rsegen.run.execute import Execution
    from rsegen.run.plan import OnExisting

    layout = ShardLayout(recipes=recipes_of(recipe), shard_maps=shard_maps, metrics=metrics)
    execution = Execution(workers=workers, scheduler=scheduler, sync=sync)
    plan = plan_dataset(layout, Path(folder), OnExisting.of(force=force, resume=resume), execution)
    return make_shards(plan, progress)


@command
def export_maps(  # noqa: PLR0913  # each is a flag
    recipes: Sequence[Recipe],
    folder: OutputFolder,
    formats: Annotated[
        Sequence[Format],
        FormatList("--to", help="formats; may be repeated"),
        Shell(("--to",), "'FORMAT KEY=VALUE ...'", required=True),
    ],
    *,
    force: Force = False,
    resume: Resume = False,
    workers: Workers = 1,
    scheduler: Scheduler = None,
    sync: Sync = True,
    progress: Callable[[ExportedMap], None] | None = None,
) -> tuple[ExportedMap, ...]:
    """Write maps in the formats of other programs: folder/NAME_0000, ..., with a folder for each format and the recipe.

    If a map is there already, as a world or exported before, the formats are added and all else stays; `resume` keeps
    formats that are complete and have the same options. A format that joins the maps, such as `ros2` with a `package`,
    is alone, and writes them into one folder of that name: all of them or none.

    Parameters
    ----------
    recipes : sequence of Recipe
        The maps.
    progress : callable, optional
        Called with each map that is written.

    Returns
    -------
    tuple of ExportedMap
        The maps that were written.

    Raises
    ------
    OutputError
        Before anything is written, if a folder of that name holds something else, a format exists already, or two maps
        have one name.
    TooLarge
        Before anything is written, if memory or disk space are too small.
    """
    from rsegen.run.execute import Execution
    from rsegen.run.exports import export_joined, joining, plan_exports
    from rsegen.run.plan import OnExisting, run

    on_existing = OnExisting.of(force=force, resume=resume)
    if together := joining(formats):
        return export_joined(recipes, Path(folder), together, on_existing, progress, sync=sync)
    execution = Execution(workers=workers, scheduler=scheduler, sync=sync)
    return run(plan_exports(recipes, Path(folder), formats, on_existing, execution), progress)


@command
def export(
    map: Recipe | Scene,  # noqa: A002  # the field's word
    path: Annotated[str | Path, FilePath("a file or folder", help="file if it has a suffix, else a folder")],
    format: Annotated[  # noqa: A002  # the command line's word
        str | None, Reference("a name in rsegen.FORMATS", help="format; default: named by the suffix of the path")
    ] = None,
    *,
    index: Annotated[int, Integer(0, SEEDS - 1, help="which map of the recipe")] = 0,
    force: Force = False,
    **options: Any,
) -> Exported:
    """Write one map in another format: `rsegen.export(recipe, "map.glb")`.

    Parameters
    ----------
    map : Recipe or Scene
        A scene, or a recipe, of which map `index` is written; in a folder the files are as in one of `export_maps`.
    **options : Any
        Options of the format, as in `rsegen.export(recipe, "folder", "mjcf", shape="hfield")`.

    Returns
    -------
    Exported
        What was written.

    Raises
    ------
    UserError
        Before anything is written, if a value is wrong or the path is taken.
    """
    from rsegen.run.exports import export_one

    return export_one(map, Path(path), format, index=index, force=force, options=options)
