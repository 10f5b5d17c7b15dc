"""Makes a data set shard by shard: each appears whole or not at all, and a line in a record says that it exists.

    recipes --plan_dataset--> DatasetPlan --shards, by workers--> files, a line each in the record --> manifest

Whatever ends a run, `resume` keeps the shards whose files still have the checksums of the record, and makes the others.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from typing import Protocol, TextIO

from rsegen.errors import OutputError
from rsegen.io.dataset.layout import ShardLayout
from rsegen.io.dataset.manifest import MANIFEST, RECORD, Shard, manifest, read_record, record_entry, record_header
from rsegen.io.dataset.planning import DatasetPlan, maps_in, plan_dataset
from rsegen.io.dataset.reading import Dataset
from rsegen.io.dataset.taken import own_names
from rsegen.io.existing import OnExisting
from rsegen.io.staging import Staging, lock_folder, remove_leftovers, staging, unlock
from rsegen.recipe.kinds import recipes_of
from rsegen.recipe.recipe import Recipe


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
    form of their table: npy, parquet or none. `force` replaces a data set that exists; `resume` continues one, and
    repairs it. With `workers` beyond 1 a script needs `if __name__ == "__main__":`. `scheduler` is the address of a
    Dask cluster whose workers see the same folder, or `local` for one with `workers` workers. `sync` waits until the
    disk has each shard, so that a power failure loses none that is finished. Raises a ParameterError if the recipes do
    not go together; an OutputError before anything is written if the folder holds something else, TooLarge if there is
    too little space.
    """
    layout = ShardLayout(recipes=recipes_of(recipe), shard_maps=shard_maps, metrics=metrics)
    on_existing = OnExisting.of(force=force, resume=resume)
    plan = plan_dataset(layout, Path(folder), on_existing, workers=workers, scheduler=scheduler, sync=sync)
    _make(plan, progress)
    return Dataset(folder)


def complete_maps(layout: ShardLayout, folder: Path) -> int:
    """How many maps of a run that was stopped are complete, in whole shards."""
    if not (folder / RECORD).is_file():
        return 0
    recorded = (shard.number for shard in read_record(folder, layout) or ())
    return maps_in(
        layout, (one for one in recorded if all((folder / name).is_file() for name in layout.names(one).values()))
    )


@contextmanager
def _locked(folder: Path) -> Iterator[None]:
    """A lock on the folder of a data set; an OutputError if another run has it."""
    lock = lock_folder(folder, wait=False)
    if lock is None:
        raise OutputError(f"{folder}: another run is making this data set; wait for it, or stop it")
    try:
        yield
    finally:
        unlock(lock)


def _make(plan: DatasetPlan, progress: Progress | None) -> None:
    """Make the shards that are missing, then the manifest."""
    folder, layout, done = plan.folder, plan.task.layout, dict(plan.existing)
    if progress:
        progress(maps_in(layout, plan.existing), already=True)
    remove_leftovers(folder)
    with staging(folder, sync=plan.task.sync) as staged, _locked(folder):
        if plan.on_existing is not OnExisting.KEEP:
            _remove_listed(folder)
        try:
            for shard in _moved_in(plan, staged):
                done[shard.number] = shard
                if progress:
                    progress(len(layout.places(shard.number)), already=False)
            _put(staged, MANIFEST, manifest(layout, (done[number] for number in sorted(done))))
            os.unlink(folder / RECORD)
        except BaseException:
            if not done:
                _remove_listed(folder)
            raise
        staged.sync_names()


def _moved_in(plan: DatasetPlan, staged: Staging) -> Iterator[Shard]:
    """The shards that are made, each in its place; before that, it has a line in the record."""
    layout = plan.task.layout
    lines = [record_header(layout), *(record_entry(layout, shard) for shard in plan.existing.values())]
    _put(staged, RECORD, "".join(lines).encode())
    with _appended(plan.folder / RECORD) as record, closing(plan.shards(staged.new)) as shards:
        for shard in shards:
            record.write(record_entry(layout, shard))
            record.flush()
            if plan.task.sync:
                os.fsync(record.fileno())
            for name in reversed(layout.names(shard.number).values()):  # where there are levels, the shard is whole
                staged.move_in(name)
            staged.sync_names()
            yield shard


def _put(staged: Staging, name: str, content: bytes) -> None:
    """One file, whole, in its place; a file of that name is replaced, and no link is followed."""
    staged.write(name, [content])
    staged.sync()
    staged.move_in(name)
    staged.sync_names()


def _appended(path: Path) -> TextIO:
    """A file that exists, opened to append lines; never what a link leads to."""
    flags = os.O_WRONLY | os.O_APPEND | getattr(os, "O_NOFOLLOW", 0)
    return open(path, "a", encoding="utf-8", newline="\n", opener=lambda name, _: os.open(name, flags))


def _remove_listed(folder: Path) -> None:
    """Remove a data set: its shards, manifest and record; nothing else."""
    for name in (MANIFEST, *sorted(own_names(folder)), RECORD):
        with suppress(FileNotFoundError):
            os.unlink(folder / name)
