"""Make a data set shard by shard, and the manifest at the end.

    recipes --plan_dataset--> DatasetPlan --make_shards: by workers or a cluster--> manifest --> Dataset

A new data set grows in its folder, and `resume` keeps the shards whose files are as the journal says. A data set that
replaces another grows in `.rsegen.next` of that folder, and takes its place in one swap.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain
from math import prod
from pathlib import Path, PurePosixPath
from typing import Protocol

from rsegen.datasets.layout import MANIFEST, Shard, ShardLayout, identity, manifest
from rsegen.datasets.reading import Dataset, arrow, table
from rsegen.errors import OutputError
from rsegen.input_files import Checksum
from rsegen.measuring.batch import batch_metrics
from rsegen.npy_files import npy_bytes
from rsegen.recipe.batch import build_many
from rsegen.writing.execute import Execution
from rsegen.writing.journal import Journal, is_empty, is_intact, read_errors, read_journal
from rsegen.writing.plan import OnExisting, Output, RunPlan, run_in
from rsegen.writing.resources import maps_in_memory, refuse_full, refuse_too_large
from rsegen.writing.store import Store, open_store, refuse_busy, refuse_irreplaceable, replacing

HOLDS = "data set"


class SeriesProgress(Protocol):
    """A function that is called when further maps exist."""

    def __call__(self, maps: int, *, already: bool) -> None:
        """Tell that `maps` more exist; `already`: from an earlier run."""


@dataclass(frozen=True, kw_only=True, slots=True)
class DatasetPlan:
    """A run that makes the shards of a data set; replaces: whether it replaces another data set in the folder."""

    layout: ShardLayout
    run: RunPlan[int, int]
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
    refuse_full((layout.maps - maps_in(layout, existing)) * layout.bytes_per_map, folder)
    known, obstacles = frozenset(existing), max(len(recipe.obstacles) for recipe in layout.recipes)
    return DatasetPlan(
        layout=layout,
        run=RunPlan(
            folder=folder,
            product=partial(_shard, layout),
            # About 30 us per map and obstacle, and 0.15 us per cell: measured on random maps, rounded.
            seconds=layout.shard_maps * (3e-5 * obstacles + prod(layout.grid_shape) * 1.5e-7),
            to_make=[number for number in range(layout.shards) if number not in known],
            existing=existing,
            execution=replace(execution, workers=min(execution.workers, *map(maps_in_memory, layout.recipes))),
            what="shards",
        ),
        replaces=replaces,
    )


def maps_in(layout: ShardLayout, numbers: Iterable[int]) -> int:
    """Return how many maps are in some shards."""
    return sum(len(layout.places(number)) for number in numbers)


def _existing(layout: ShardLayout, folder: Path, on_existing: OnExisting) -> list[int]:
    """Return the shards that exist and are kept; an OutputError if the folder may be neither continued nor replaced."""
    journal = read_journal(folder)
    if journal is None or journal.holds != HOLDS:
        raise OutputError(f"{folder}: is not empty, and not a data set of rsegen; use another folder")
    if on_existing is OnExisting.REFUSE:
        raise OutputError(
            f"{folder}: a data set exists already; use resume=True to continue it, force=True to replace it, or "
            "another folder"
        )
    if on_existing is OnExisting.REPLACE:
        return []
    if journal.of != identity(layout):
        raise OutputError(
            f"{folder}: contains a different data set (seed, number of maps, their design, maps per file, metrics, "
            "a plug-in or rsegen's version differ); use those of the interrupted run, or another folder"
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


def make_shards(plan: DatasetPlan, progress: SeriesProgress | None) -> Dataset:
    """Make the shards that are missing, then the manifest; return the data set."""
    layout, shards_run = plan.layout, plan.run
    with _opened(plan) as store:
        names = {number: layout.names(number).values() for number in range(layout.shards)}
        existing = shards_run.existing  # none if another data set is replaced
        journal = store.journal.content
        unchanged = [name for number in existing for name in names[number]]
        if len(existing) == layout.shards and is_intact(store.folder, MANIFEST, journal):
            unchanged.append(MANIFEST)
        store.announce_files([*chain(*names.values()), MANIFEST], kept=unchanged)
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
            Shard(number=number, files={content: files[name][-1] for content, name in layout.names(number).items()})
            for number in range(layout.shards)
        ]
        listing = manifest(layout, shards)
        # An equal manifest stays, so that a run that has nothing to do writes nothing.
        if not is_intact(store.folder, MANIFEST, store.journal.content) or files[MANIFEST][-1] != Checksum.of(listing):
            store.put({MANIFEST: [listing]}, force=True)
    return Dataset(plan.run.folder)


@contextmanager
def _opened(plan: DatasetPlan) -> Iterator[Store]:
    """Open the folder of the data set, or the hidden one that replaces it at the end."""
    folder, of = plan.run.folder, identity(plan.layout)
    if plan.replaces:
        with replacing(folder, HOLDS, of, sync=plan.run.execution.sync) as store:
            yield store
    else:
        with open_store(folder, sync=plan.run.execution.sync) as store:
            store.journal.begin(HOLDS, of)
            yield store


def _shard(layout: ShardLayout, number: int) -> Output[int]:
    """Return the files of a shard by its number: the levels and metrics of some maps."""
    names = layout.names(number)
    wide = build_many(layout.recipe_of_shard(number), layout.indices(number))
    levels = wide.astype(layout.dtype)
    if (levels != wide).any():
        raise OverflowError(f"a level of shard {number} is no {layout.dtype}")
    files = {PurePosixPath(names["levels"]): [npy_bytes(levels)]}
    if layout.metrics != "none":
        content = table(layout.metrics, layout.indices(number), batch_metrics(levels, layout.flat_field))
        files[PurePosixPath(names["metrics"])] = [content]
    return Output(made=number, files=files, adds=True, holds=HOLDS, force=frozenset(names.values()))
