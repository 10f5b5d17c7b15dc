"""The commands that write many maps: series and dataset."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from rsegen.cli.edge import how_to_go_on
from rsegen.cli.flags import (
    RECIPE_HELP,
    add_input,
    add_recipe_flags,
    has_recipe_flags,
    recipe_from,
    with_flags,
)
from rsegen.cli.generate import add_output_flags, generate, going_on, run_options, warnings_of
from rsegen.cli.parameters import Force, OutputFolder, Resume, Scheduler, Sync, Workers
from rsegen.cli.parser import Parser
from rsegen.cli.report import Report, call, counting, progress_shown
from rsegen.errors import ParameterError
from rsegen.measuring.parameters import By, ByRobot, From, SameField, To
from rsegen.params.command import add_flags, command, declared, given
from rsegen.params.numbers import counted
from rsegen.params.sorts import Choice, Integer
from rsegen.writing.sidecars import chosen_sidecars, with_sidecars

if TYPE_CHECKING:
    from rsegen.datasets.making import SeriesProgress
    from rsegen.datasets.reading import Dataset
    from rsegen.datasets.series import Series
    from rsegen.datasets.series_rows import SeriesRow
    from rsegen.recipe.recipe import Recipe


@command
@with_sidecars
def series(  # noqa: PLR0913  # each is a flag
    recipe: Recipe,
    folder: OutputFolder,
    *,
    maps: int | None = None,
    from_: From = 0.1,
    to: To = 1.0,
    same_field: SameField = False,
    by: By = "steps.rms",
    robot: ByRobot = None,
    force: Force = False,
    resume: Resume = False,
    workers: Workers = 1,
    scheduler: Scheduler = None,
    sync: Sync = True,
    progress: Callable[[SeriesRow], None] | None = None,
    **sidecars: Any,
) -> Series:
    """Write maps of evenly rising difficulty, a table of what they measure (series.csv) and a picture (series.png).

    Table and picture come last, whole or not at all. In Python `by` may be a function StepField -> float too, which is
    called in this process alone. Errors are as in `generate`.

    Parameters
    ----------
    recipe : Recipe
        The maps.
    maps : int, optional
        Their number; by default as the recipe says.
    progress : callable, optional
        Called with the row of each map that is done.

    Returns
    -------
    Series
        The maps on disk, and what they measure.
    """
    from rsegen.datasets.series import make_series, plan_series
    from rsegen.datasets.series_rows import SeriesPlan
    from rsegen.recipe.recipe import with_maps
    from rsegen.writing.execute import Execution
    from rsegen.writing.plan import OnExisting

    recipe = with_maps(recipe, maps)
    series_plan = SeriesPlan(recipe=recipe, from_=from_, to=to, same_field=same_field, by=by, robot=robot)  # type: ignore[arg-type]  # checked
    execution = Execution(workers=workers, scheduler=scheduler, sync=sync)
    plan = plan_series(
        series_plan, Path(folder), chosen_sidecars(sidecars), OnExisting.of(force=force, resume=resume), execution
    )
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
    progress: SeriesProgress | None = None,
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
    from rsegen.datasets.layout import ShardLayout
    from rsegen.datasets.making import make_shards, plan_dataset
    from rsegen.recipe.recipe import as_recipes
    from rsegen.writing.execute import Execution
    from rsegen.writing.plan import OnExisting
    from rsegen.writing.store import put_back_whole

    layout = ShardLayout(recipes=as_recipes(recipe), shard_maps=shard_maps, metrics=metrics)
    execution = Execution(workers=workers, scheduler=scheduler, sync=sync)
    put_back_whole(Path(folder))
    plan = plan_dataset(layout, Path(folder), OnExisting.of(force=force, resume=resume), execution)
    return make_shards(plan, progress)


_ROWS = 12
"""Rows of a series that are printed."""


def add_series(command: Parser) -> None:
    """Add the flags of `rsegen series`."""
    epilog = "docs/difficulty.md defines difficulty, and shows how near the maps come to it."
    command.explain(series.__doc__, epilog)
    add_input(command.group("input"))
    add_output_flags(command, series)
    add_flags(command.group("difficulty"), series, without=declared(generate))
    add_recipe_flags(command)


def run_series(arguments: argparse.Namespace) -> Report:
    """Write a series, and report how it rises."""
    recipe = recipe_from(arguments)
    options = run_options(series, arguments)
    with going_on(arguments, recipe), counting(recipe.maps) as progress:
        made = call(series, arguments, recipe, **options, progress=progress)
    return Report(lines=_series_lines(made), content=lambda: _series_content(made))


def _series_content(made: Series) -> dict[str, object]:
    rows = [asdict(row) | {"folder": str(made.folder / row.map)} for row in made.rows]
    files = {"table": str(made.table), "picture": str(made.picture)}
    return {"folder": str(made.folder), "seed": made.plan.recipe.seed, **files, "maps": rows}


def _series_lines(made: Series) -> Iterator[str]:
    from rsegen.params.numbers import decimal, lengths_in

    rows, existed, written = made.rows, len(made.rows) - len(made.maps), lengths_in(made.plan.recipe.units)
    already = f", {existed} existed before" if existed else ""
    maps, seed = counted(len(rows), "map"), made.plan.recipe.seed
    yield f"{maps} in {made.folder}, seed {seed}{already}; lengths in {written.name}:"
    width, by_default = max(len(row.map) for row in rows), made.plan.by == declared(series)["by"].default
    names, unit = ("rms asked", "rms step") if by_default else ("asked", "measured"), made.plan.metric.unit
    yield f"  {'map':<{width}}" + "".join(f"{name:>12}" for name in ("difficulty", *names, "highest"))
    # On the screen a long series has some of its rows alone; the file has all of them.
    for row in _some(rows):
        values = (row.asked, unit), (row.measured, unit), (row.highest_step, "m")
        factors = ((value, written.per_metre if of == "m" else 1.0) for value, of in values)
        lengths = ("-" if value is None else f"{value * factor:.2f}" for value, factor in factors)
        yield f"  {row.map:<{width}}{decimal(row.difficulty):>12}" + "".join(f"{text:>12}" for text in lengths)
    if len(rows) > _ROWS:
        yield f"  ({len(rows) - len(_some(rows))} rows between them are left out)"
    yield from warnings_of(made.maps)
    yield f"all rows: {made.table}"
    yield f"a picture: {made.picture}"


def _some(rows: tuple[SeriesRow, ...]) -> list[SeriesRow]:
    """Return all rows, or some that are evenly spaced, with the last."""
    apart = -(-len(rows) // _ROWS)
    return [*rows[:-1:apart], rows[-1]]


_REBUILT = Integer(0, 10**9)


def add_dataset(command: Parser) -> None:
    """Add the flags of `rsegen dataset`."""
    epilog = "DIR#17 then names one of its maps in every command: rsegen generate DIR#17 -o worlds. docs/datasets.md "
    command.explain(make_dataset.__doc__, f"{epilog}shows how to read it in Python, and how to train on it.")
    text = f"{RECIPE_HELP}; flags apply to every recipe, so --maps N makes N maps of each"
    add_input(command.group("input"), text, name="recipes", nargs="*")
    group = command.group("output")
    task = group.one_of()
    task.add_argument("-o", "--output", dest="folder", metavar="DIR", help="folder for the data set")
    task.add_argument("--verify", metavar="DIR", help="check every file of the data set in DIR instead")
    add_flags(group, make_dataset, without=["folder"])
    group.add_argument("--rebuild", metavar="N", help="with --verify: maps to rebuild and compare (default: 100)")
    add_recipe_flags(command)


def run_dataset(arguments: argparse.Namespace) -> Report:
    """Write a data set, or check one, and report what is in it."""
    if arguments.verify is not None:
        dataset, words = _verified(arguments)
    else:
        dataset = _made(arguments)
        words = f"one of them as a world: rsegen generate {shlex.quote(f'{dataset.folder}#0')} -o worlds"
    distinct = {recipe.name: dataset.distinct(recipe.name) for recipe in dataset.recipes}
    lines = [_described(dataset), *_repeated(distinct), words]
    return Report(lines=lines, content=lambda: _content(dataset, distinct))


def _repeated(distinct: Mapping[str, tuple[int, int]]) -> Iterator[str]:
    """Yield a line for each recipe that makes the same map again, as one set of its maps then holds maps of another.

    distinct: by the name of a recipe, how many different maps there are among how many that were compared
    """
    for name, (different, compared) in distinct.items():
        if different < compared:
            yield (
                f"note: {different:,} of the first {compared:,} maps of {name} are different; other seeds and indices "
                "make the same maps too"
            )


def _verified(arguments: argparse.Namespace) -> tuple[Dataset, str]:
    """Return the data set that was checked, and what it was compared with."""
    from rsegen.datasets.reading import Dataset

    if arguments.recipes or has_recipe_flags(arguments):
        raise ParameterError("--verify", "needs no recipe: it is in the data set")
    for name in given(make_dataset, arguments):
        flag = declared(make_dataset)[name].flags[0]
        raise ParameterError(flag, "is for a data set that is made; --verify checks one")
    text = arguments.rebuild
    rebuild = 100 if text is None else _REBUILT.check("--rebuild", _REBUILT.parse(text))
    dataset = Dataset(Path(arguments.verify))
    dataset.verify(rebuild)
    built = min(rebuild, len(dataset))
    return dataset, f"all checksums are right, and {built} random maps were rebuilt and are equal"


def _made(arguments: argparse.Namespace) -> Dataset:
    from rsegen.recipe.recipe import Recipe
    from rsegen.recipe.recipe_file import named_recipe

    if arguments.rebuild is not None:
        raise ParameterError("--rebuild", "is for --verify DIR, which compares maps of a data set that exists")
    starts = [named_recipe(name) for name in arguments.recipes] or [Recipe()]
    recipes, options = [with_flags(start, arguments) for start in starts], run_options(make_dataset, arguments)
    resume, then = not arguments.force, "goes on" if arguments.force else "makes the others"
    maps = sum(recipe.maps for recipe in recipes)
    with how_to_go_on(*recipes, resume=resume, then=then), shards_bar(maps) as progress:
        return call(make_dataset, arguments, recipes, **options, progress=progress)


def _content(dataset: Dataset, distinct: Mapping[str, tuple[int, int]]) -> dict[str, object]:
    names = ("name", "seed", "maps")
    recipes = [{name: getattr(recipe, name) for name in names} for recipe in dataset.recipes]
    return {
        "folder": str(dataset.folder),
        **({"recipes": recipes} if recipes[1:] else {"seed": dataset.recipe.seed}),
        "maps": len(dataset),
        "shape": list(dataset.levels.shape),
        "dtype": dataset.levels.dtype.name,
        "metrics": dataset.layout.metrics,
        "shards": len(dataset.shards),
        "bytes": dataset.bytes,
        "distinct": {name: {"maps": of, "different": count} for name, (count, of) in distinct.items()},
    }


def _described(dataset: Dataset) -> str:
    n_x, n_y = dataset.layout.grid_shape
    seeds = [f"{recipe.maps:,} of {recipe.name} (seed {recipe.seed})" for recipe in dataset.recipes]
    seed_text = ", ".join(seeds) if len(seeds) > 1 else f"seed {dataset.recipe.seed}"
    shards = counted(len(dataset.shards), "shard")
    return (
        f"{counted(len(dataset), 'map')} of {n_x} x {n_y} blocks, {seed_text}: "
        f"{dataset.bytes:,} bytes in {shards} in {dataset.folder}"
    )


@contextmanager
def shards_bar(maps: int) -> Iterator[SeriesProgress]:
    """Yield a function for maps in shards; those that exist already are of no weight in the time that is left."""
    with progress_shown(maps, "map", unit_scale=True) as bar:

        def done(maps: int, *, already: bool) -> None:
            bar.initial += maps * already
            bar.update(maps)

        yield done
