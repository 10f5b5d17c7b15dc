"""Make a data set shard by shard, and the manifest at the end.

    recipes --plan_dataset--> DatasetPlan --make_dataset: shards, by workers or a cluster--> manifest --> Dataset

A new data set grows in its folder, and `resume` keeps the shards whose files are as the journal says. A data set that
replaces another grows in `.rsegen.next` of that folder, and takes its place in one swap.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path, PurePosixPath
from typing import Protocol

from rsegen.errors import OutputError
from rsegen.field.metrics.batch import batch_metrics
from rsegen.field.stepfield import Levels
from rsegen.io.dataset.layout import MANIFEST, Shard, ShardLayout, header, manifest
from rsegen.io.dataset.reading import Dataset, arrow, npy, table
from rsegen.io.resources import maps_in_memory, refuse_full, refuse_too_large
from rsegen.recipe.batch import build_many
from rsegen.recipe.recipe import Recipe
from rsegen.recipe.tiles import recipes_of
from rsegen.run.execute import Execution
from rsegen.run.journal import Journal, is_empty, is_intact, read_errors, read_journal
from rsegen.run.plan import OnExisting, Output, RunPlan, run_in
from rsegen.run.store import Store, open_store, refuse_busy, refuse_irreplaceable, replacing

HOLDS = "data set"


class Progress(Protocol):
    """A function that is called when further maps exist."""

    def __call__(self, maps: int, *, already: bool) -> None:
        """`maps` more exist; `already`: from an earlier run."""


def make_dataset(  # noqa: PLR0913  # each is a flag of the command
    recipe: Recipe | Sequence[Recipe],
    folder: str | Path,
    *,
    metrics: str = "npy",
    shard_maps: int = 0,
    force: bool = False,
    resume: bool = False,
    workers: int = 1,
    scheduler: str | None = None,
    sync: bool = True,
    progress: Progress | None = None,
) -> Dataset:
    """Make a data set of all maps of some recipes, in shards of `shard_maps` (0: about a million cells each).

    Several recipes have different names, and maps of one size, unit, width of blocks and boundary. `metrics` is the
    form of their table: npy, parquet or none. `force` replaces a data set that exists, in one step once the new one is
    complete; `resume` continues one that was stopped, or completes one whose files are missing. With `workers` beyond 1
    a script needs `if __name__ == "__main__":`. `scheduler` is the address of a Dask cluster whose workers see the same
    folder, or `local` for one with `workers` workers. `sync` waits until the disk has each shard, so that a power
    failure loses none that is finished. Raises a ParameterError if the recipes do not go together; an OutputError
    before anything is written if the folder holds something else, TooLarge if there is too little space.
    """
    layout = ShardLayout(recipes=recipes_of(recipe), shard_maps=shard_maps, metrics=metrics)
    on_existing = OnExisting.of(force=force, resume=resume)
    execution = Execution(workers=workers, scheduler=scheduler, sync=sync)
    plan = plan_dataset(layout, Path(folder), on_existing, execution)
    _make(plan, progress)
    return Dataset(folder)


@dataclass(frozen=True, kw_only=True, slots=True)
class DatasetPlan:
    """A run that makes the shards of a data set, the bytes of disk that they need, and how many maps exist already.

    replaces: whether it replaces another data set in the folder
    """

    layout: ShardLayout
    run: RunPlan[int, int]
    disk: int
    existing_maps: int
    replaces: bool


def plan_dataset(
    layout: ShardLayout, folder: Path, on_existing: OnExisting, execution: Execution | None = None
) -> DatasetPlan:
    """Check that a data set can be made, and plan it; nothing is written. Raises as `make_dataset` does."""
    # Packages and memory first, then what the folder holds, then room on the disk for what is to be made.
    execution = execution or Execution()
    if layout.metrics == "parquet":
        arrow()
    for recipe in layout.recipes:
        refuse_too_large(recipe, "build" if layout.metrics == "none" else "measure")
    refuse_busy(folder)
    with read_errors(folder):
        is_new = is_empty(folder) and read_journal(folder) is None
        existing = [] if is_new else _existing(layout, folder, on_existing)
    replaces = not is_new and on_existing is OnExisting.REPLACE
    if replaces:
        refuse_irreplaceable(folder, HOLDS)
    disk = (layout.maps - maps_in(layout, existing)) * layout.bytes_per_map
    refuse_full(disk, folder)
    known = frozenset(existing)
    return DatasetPlan(
        layout=layout,
        run=RunPlan(
            folder=folder,
            product=_Shards(layout=layout),
            to_make=[number for number in range(layout.shards) if number not in known],
            existing=existing,
            execution=replace(execution, workers=min(execution.workers, *map(maps_in_memory, layout.recipes))),
            what="shards",
        ),
        disk=disk,
        existing_maps=maps_in(layout, existing),
        replaces=replaces,
    )


def maps_in(layout: ShardLayout, numbers: Iterable[int]) -> int:
    """Return how many maps are in some shards."""
    return sum(len(layout.places(number)) for number in numbers)


def _existing(layout: ShardLayout, folder: Path, on_existing: OnExisting) -> list[int]:
    """Return the shards that exist and are kept; an OutputError if the folder may be neither continued nor replaced."""
    journal = read_journal(folder)
    if journal is None or journal.holds != HOLDS:
        raise OutputError(f"{folder}: is not empty, and not a data set of rsegen; give another folder")
    if on_existing is OnExisting.REFUSE:
        raise OutputError(
            f"{folder}: a data set exists there already; give --resume to continue it, --force to replace it, or "
            "another folder"
        )
    if on_existing is OnExisting.REPLACE:
        return []
    if journal.of != header(layout):
        raise OutputError(
            f"{folder}: contains a different data set (seed, number of maps, a parameter or rsegen's version differ); "
            "use those of the interrupted run, or another folder"
        )
    return complete_shards(layout, folder, journal)


def complete_shards(layout: ShardLayout, folder: Path, journal: Journal) -> list[int]:
    """Return the shards whose files are as the journal says; an OutputError for a file that was changed since."""
    is_intact(folder, MANIFEST, journal)
    return [
        number
        for number in range(layout.shards)
        if all([is_intact(folder, name, journal) for name in layout.names(number).values()])  # noqa: C419  # each is checked
    ]


def _make(plan: DatasetPlan, progress: Progress | None) -> None:
    """Make the shards that are missing, then the manifest."""
    layout, shards_run = plan.layout, plan.run
    with _opened(plan) as store:
        journal = store.journal.content
        if plan.replaces and journal:  # what an earlier run of the same command has made
            existing = complete_shards(layout, store.folder, journal)
            known = frozenset(existing)
            missing = [number for number in shards_run.to_make if number not in known]
            shards_run = replace(shards_run, existing=existing, to_make=missing)
        if progress:
            progress(maps_in(layout, shards_run.existing), already=True)

        def done(number: int) -> None:
            if progress:
                progress(len(layout.places(number)), already=False)

        run_in(store, shards_run, done)
        files = store.journal.content.files if store.journal.content else {}
        shards = [
            Shard(number=number, files={what: files[name][-1] for what, name in layout.names(number).items()})
            for number in range(layout.shards)
        ]
        if shards_run.to_make or not is_intact(store.folder, MANIFEST, store.journal.content):
            store.put({MANIFEST: [manifest(layout, shards)]}, force=True)


@contextmanager
def _opened(plan: DatasetPlan) -> Iterator[Store]:
    """Open the folder of the data set, or the hidden one that replaces it at the end."""
    folder, of = plan.run.folder, header(plan.layout)
    if plan.replaces:
        with replacing(folder, HOLDS, of, sync=plan.run.execution.sync) as store:
            yield store
    else:
        with open_store(folder, sync=plan.run.execution.sync) as store:
            store.journal.begin(HOLDS, of)
            yield store


@dataclass(frozen=True, kw_only=True, slots=True)
class _Shards:
    """A product that makes shards by their numbers: the levels and metrics of some maps."""

    layout: ShardLayout

    @property
    def seconds(self) -> float:
        """About 30 us per map and obstacle, and 0.15 us per cell: measured on random maps, rounded."""
        n_x, n_y = self.layout.grid_shape
        obstacles = max(len(recipe.obstacles) for recipe in self.layout.recipes)
        return self.layout.shard_maps * (3e-5 * obstacles + n_x * n_y * 1.5e-7)

    def __call__(self, number: int, /) -> Output[int]:
        layout, names = self.layout, self.layout.names(number)
        levels = self._levels(number)
        files = {PurePosixPath(names["levels"]): [npy(levels)]}
        if layout.metrics != "none":
            content = table(layout.metrics, layout.indices(number), batch_metrics(levels, layout.flat_field))
            files[PurePosixPath(names["metrics"])] = [content]
        return Output(made=number, files=files, adds=True, holds=HOLDS, force=frozenset(names.values()))

    def _levels(self, number: int) -> Levels:
        levels = build_many(self.layout.recipe_of_shard(number), self.layout.indices(number))
        narrow = levels.astype(self.layout.dtype)
        if (narrow != levels).any():
            raise OverflowError(f"a level of shard {number} is no {self.layout.dtype}")
        return narrow
