"""Makes a data set shard by shard: each appears whole or not at all, and a line in a record says that it exists.

    recipe --plan_dataset--> DatasetPlan --shards, by workers--> files, a line each in the record --> manifest

Whatever ends a run, `resume` keeps the shards whose files still have the checksums of the record, and makes the others.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from typing import Protocol, TextIO

from rsegen.errors import OutputError
from rsegen.io.dataset.layout import ShardLayout
from rsegen.io.dataset.manifest import MANIFEST, RECORD, Shard, manifest, read_record, record_entry, record_header
from rsegen.io.dataset.planning import HIDDEN, OURS, DatasetPlan, maps_in, plan_dataset
from rsegen.io.dataset.reading import Dataset
from rsegen.io.existing import OnExisting
from rsegen.io.writer import as_write_errors, parents_made, write_file
from rsegen.recipe.recipe import Recipe


class Progress(Protocol):
    """A function that is called when further maps exist."""

    def __call__(self, maps: int, *, already: bool) -> None:
        """`maps` more exist; `already`: from an earlier run."""


def make_dataset(  # noqa: PLR0913  # each is a flag of the command
    recipe: Recipe,
    folder: str | Path,
    *,
    metrics: str = "npy",
    shard_maps: int = 0,
    force: bool = False,
    resume: bool = False,
    workers: int = 1,
    scheduler: str | None = None,
    progress: Progress | None = None,
) -> Dataset:
    """Make a data set of all maps of a recipe, in shards of `shard_maps` (0: about a million cells each).

    `metrics` is the form of their table: npy, parquet or none. `force` replaces a data set that is there; `resume` goes
    on with one, and mends it. With `workers` beyond 1 a script needs `if __name__ == "__main__":`. `scheduler` is the
    address of a Dask cluster whose workers see the same folder, or `local` for one with `workers` workers. Raises an
    OutputError before anything is written if the folder holds something else, TooLarge if there is too little space.
    """
    layout = ShardLayout(recipe=recipe, shard_maps=shard_maps, metrics=metrics)
    on_existing = OnExisting.of(force=force, resume=resume)
    plan = plan_dataset(layout, Path(folder), on_existing, workers=workers, scheduler=scheduler)
    _make(plan, progress)
    return Dataset(folder)


def complete_maps(layout: ShardLayout, folder: Path) -> int:
    """How many maps of a run that was stopped are complete, in whole shards."""
    if not (folder / RECORD).is_file():
        return 0
    return maps_in(layout, (shard.number for shard in read_record(folder, layout) or ()))


@contextmanager
def _lock(path: Path) -> Iterator[TextIO]:
    """The record, removed when all is done; an OutputError if another run has it open, if the system can tell."""
    with open(path, "a", encoding="utf-8", newline="\n") as record:
        try:
            import fcntl

            fcntl.flock(record, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise OutputError(f"{path.parent}: another run is making this data set; wait for it, or stop it") from None
        except (ImportError, OSError):  # Windows; a network's disk without locks
            pass
        yield record
    path.unlink()


def _clear(folder: Path, *, everything: bool) -> None:
    """Remove what a killed run left half written; `everything`: also the data set that was there, and nothing else."""
    names = os.listdir(folder)
    ours = [name for name in names if HIDDEN.fullmatch(name) or (everything and OURS.fullmatch(name))]
    for name in sorted(ours, key=lambda name: name != MANIFEST):
        os.unlink(folder / name)


def _make(plan: DatasetPlan, progress: Progress | None) -> None:
    """Make the shards that are missing, then the manifest."""
    folder, layout = plan.task.folder, plan.task.layout
    if progress:
        progress(maps_in(layout, plan.existing), already=True)
    with as_write_errors(folder), parents_made(folder / MANIFEST), _lock(folder / RECORD) as record:
        _clear(folder, everything=plan.on_existing is not OnExisting.KEEP)
        done = dict(plan.existing)
        try:
            for shard in _recorded_shards(plan, record):
                done[shard.number] = shard
                if progress:
                    progress(len(layout.places(shard.number)), already=False)
            write_file([manifest(layout, (done[number] for number in sorted(done)))], folder / MANIFEST, force=True)
        except BaseException:
            with suppress(OSError):
                _clear(folder, everything=not done)
                if not done:
                    os.unlink(folder / RECORD)
            raise


def _recorded_shards(plan: DatasetPlan, record: TextIO) -> Iterator[Shard]:
    """The shards that are made, each with a line in the record."""
    layout = plan.task.layout
    record.truncate(0)
    entries = (record_entry(layout, shard) for shard in plan.existing.values())
    record.write(record_header(layout) + "".join(entries))
    record.flush()
    with closing(plan.shards()) as shards:
        for shard in shards:
            record.write(record_entry(layout, shard))
            record.flush()
            yield shard
