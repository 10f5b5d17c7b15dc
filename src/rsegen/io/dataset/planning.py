"""What a run that makes a data set will do; everything is checked before anything is written.

layout, folder --plan_dataset--> DatasetPlan
"""

from __future__ import annotations

from collections.abc import Generator, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from rsegen.errors import OutputError
from rsegen.io.dataset.cluster import dask, on_cluster
from rsegen.io.dataset.layout import ShardLayout
from rsegen.io.dataset.manifest import MANIFEST, RECORD, Shard, read_manifest, read_record, same_maps
from rsegen.io.dataset.shards import ShardTask
from rsegen.io.dataset.tables import arrow
from rsegen.io.dataset.taken import refuse_taken
from rsegen.io.existing import OnExisting
from rsegen.io.record import written_file
from rsegen.io.resources import maps_in_memory, refuse_full, refuse_too_large
from rsegen.io.work import WORKERS, run_each
from rsegen.io.writer import refuse_not_a_folder


@dataclass(frozen=True, kw_only=True, slots=True)
class DatasetPlan:
    """Which shards a run will make, which exist and stay, and the bytes of disk that it needs.

    workers: how many processes take part, at the most   scheduler: of the cluster that makes them, if there is one
    """

    task: ShardTask
    to_make: Sequence[int]
    existing: Mapping[int, Shard]
    on_existing: OnExisting
    disk: int
    workers: int
    scheduler: str | None = None

    @property
    def folder(self) -> Path:
        """Where the data set will be."""
        return self.task.folder

    def shards(self, hidden: Path) -> Generator[Shard, None, None]:
        """The shards that are missing, made in a hidden folder by a cluster, by workers if that is quicker, or here."""
        task = replace(self.task, folder=hidden)
        if self.scheduler is None or not self.to_make:
            return run_each(task, self.to_make, self.workers)
        workers = min(self.workers, len(self.to_make))
        return on_cluster(task.make, self.to_make, scheduler=self.scheduler, workers=workers)


def plan_dataset(  # each is a flag of the command
    layout: ShardLayout,
    folder: Path,
    on_existing: OnExisting,
    *,
    workers: int = 1,
    scheduler: str | None = None,
    sync: bool = True,
) -> DatasetPlan:
    """Check that a data set can be made, and plan it; nothing is written. Raises as `make_dataset` does."""
    workers = WORKERS.check("workers", workers)
    _refuse_missing(layout, scheduler)
    for recipe in layout.recipes:
        refuse_too_large(recipe, "build" if layout.metrics == "none" else "measure")
    refuse_not_a_folder(folder)
    refuse_taken(folder, on_existing)
    task = ShardTask(layout=layout, folder=folder.absolute(), sync=sync)
    keeps = on_existing is OnExisting.KEEP
    existing = {shard.number: shard for shard in _existing(task)} if keeps else {}
    to_make = [number for number in range(layout.shards) if number not in existing]
    disk = (layout.maps - maps_in(layout, existing)) * layout.bytes_per_map
    refuse_full(disk, folder)
    return DatasetPlan(
        task=task,
        to_make=to_make,
        existing=existing,
        on_existing=on_existing,
        disk=disk,
        workers=min(workers, *map(maps_in_memory, layout.recipes)),
        scheduler=scheduler,
    )


def maps_in(layout: ShardLayout, numbers: Iterable[int]) -> int:
    """How many maps are in some shards."""
    return sum(len(layout.places(number)) for number in numbers)


def _refuse_missing(layout: ShardLayout, scheduler: str | None) -> None:
    """Raise a ParameterError if a package is not installed that is needed."""
    if layout.metrics == "parquet":
        arrow()
    if scheduler is not None:
        dask()


def _existing(task: ShardTask) -> Iterator[Shard]:
    """The shards that exist, to the byte; OutputError if the data set in the folder is another."""
    recorded = _recorded(task)
    if recorded is None:
        raise OutputError(
            f"{task.folder}: holds another data set: of another seed, number of maps, parameter or version of rsegen; "
            "give those of the run that was stopped, or another folder"
        )
    for shard in recorded:
        names = task.layout.names(shard.number)
        if all(file == written_file(task.folder / names[what]) for what, file in shard.files.items()):
            yield shard


def _recorded(task: ShardTask) -> list[Shard] | None:
    if (task.folder / MANIFEST).is_file():
        layout, shards = read_manifest(task.folder)
        return shards if same_maps(layout, task.layout) else None
    return read_record(task.folder, task.layout) if (task.folder / RECORD).is_file() else []
