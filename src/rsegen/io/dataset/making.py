"""A data set is made shard by shard: each appears whole or not at all, and a line in the record says that it is there.

    Layout --shards, by workers--> files, a line each in the record --the last one--> manifest

Whatever ends a run, `resume` keeps the shards whose files still have the checksums of the record, and makes the others.
"""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Protocol, TextIO

import numpy as np

from rsegen.errors import OutputError, ParameterError
from rsegen.field.metrics.batch import batch_metrics
from rsegen.field.stepfield import Levels
from rsegen.io.dataset.checking import measured
from rsegen.io.dataset.cluster import dask, on_cluster
from rsegen.io.dataset.layout import Layout
from rsegen.io.dataset.manifest import (
    MANIFEST,
    RECORD,
    Part,
    Shard,
    first_line,
    manifest,
    next_line,
    read_manifest,
    read_record,
)
from rsegen.io.dataset.reading import Dataset
from rsegen.io.dataset.tables import arrow, npy, table
from rsegen.io.resources import BYTES_A_CELL_OF_METRICS, maps_at_once, refuse_full, refuse_too_large
from rsegen.io.work import WORKERS, each
from rsegen.io.writer import parent_of, refuse_not_a_folder, told, write_file
from rsegen.recipe.building import blocks
from rsegen.recipe.recipe import Recipe

_OURS = re.compile(r"(levels-[0-9]{5,}\.npy|metrics-[0-9]{5,}\.(npy|parquet)|manifest\.json)")
_HIDDEN = re.compile(rf"\.{_OURS.pattern}\.[0-9a-f]{{8}}")


class Progress(Protocol):
    """Is told how many maps more are there, and whether they were there already."""

    def __call__(self, maps: int, *, already: bool) -> None:
        """So many."""


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
    address of a Dask cluster whose workers see the same folder, or `local` for one of so many workers. Raises an
    OutputError before anything is written where the folder holds something else, TooLarge where there is no room.
    """
    folder, workers = Path(folder), WORKERS.check("workers", workers)
    if force and resume:
        raise ParameterError("resume", "--resume and --force exclude each other")
    layout = Layout(recipe=recipe, shard_maps=shard_maps, metrics=metrics)
    if layout.metrics == "parquet":
        arrow()
    if scheduler is not None:
        dask()
    refuse_too_large(recipe, 0 if layout.metrics == "none" else BYTES_A_CELL_OF_METRICS)
    refuse_not_a_folder(folder)
    _refuse_taken(folder, force=force, resume=resume)
    order = Order(layout=layout, folder=folder.absolute())
    there = {shard.number: shard for shard in _there(order)} if resume else {}
    maps_there = sum(len(layout.places(number)) for number in there)
    refuse_full((recipe.maps - maps_there) * layout.bytes_a_map, folder)
    if progress:
        progress(maps_there, already=True)
    with told(folder), parent_of(folder / MANIFEST), _alone(folder / RECORD) as record:
        _clear(folder, everything=not resume)
        _finish(order, there, partial(_made, workers=workers, scheduler=scheduler), record, progress)
    return Dataset(folder)


@dataclass(frozen=True, kw_only=True, slots=True)
class Order:
    """Which shards to make, and where: all that a worker is told."""

    layout: Layout
    folder: Path

    @property
    def seconds(self) -> float:
        """About how long a shard takes; it decides how the work is shared out, not what comes of it."""
        n_x, n_y = self.layout.recipe.grid.shape
        return self.layout.shard_maps * (3e-5 * len(self.layout.recipe.obstacles) + n_x * n_y * 1.5e-7)

    @property
    def at_once(self) -> int:
        """How many fit into memory together."""
        return maps_at_once(self.layout.recipe)

    def __call__(self, numbers: Iterable[int]) -> tuple[Shard, ...]:
        """Shards, on disk."""
        return tuple(map(self.made, numbers))

    def made(self, number: int) -> Shard:
        """One shard, on disk; its levels are there last."""
        layout, names = self.layout, self.layout.names(number)
        levels, parts = self._levels(number), {}
        if layout.metrics != "none":
            content = table(layout.metrics, layout.indices(number), batch_metrics(levels, layout.like))
            parts["metrics"] = self._written(names["metrics"], content)
        return Shard(number=number, parts={"levels": self._written(names["levels"], npy(levels)), **parts})

    def _levels(self, number: int) -> Levels:
        levels = np.empty(self.layout.shape(number), dtype=np.int16)
        for place, index in enumerate(self.layout.indices(number)):
            levels[place] = blocks(self.layout.recipe, index)
        found = levels.astype(self.layout.dtype)
        if (found != levels).any():
            raise OverflowError(f"a level of shard {number} is no {self.layout.dtype}")
        return found

    def _written(self, name: str, content: bytes) -> Part:
        write_file([content], self.folder / name, force=True)
        return Part(bytes=len(content), sha256=hashlib.sha256(content).hexdigest())


def complete_maps(layout: Layout, folder: Path) -> int:
    """How many maps of a run that was stopped are in whole shards."""
    if not (folder / RECORD).is_file():
        return 0
    return sum(len(layout.places(shard.number)) for shard in read_record(folder, layout) or ())


def _refuse_taken(folder: Path, *, force: bool, resume: bool) -> None:
    """Raise an OutputError where the folder holds anything that is not to be gone on with, or replaced."""
    names = os.listdir(folder) if folder.is_dir() else []
    if any(name in (MANIFEST, RECORD) for name in names):
        if not (force or resume):
            raise OutputError(
                f"{folder}: a data set is there already; give --resume to go on with it, --force to replace it, or "
                "another folder"
            )
    elif any(not _HIDDEN.fullmatch(name) for name in names):
        raise OutputError(f"{folder}: is not empty, and no data set of rsegen; give another folder")


def _there(order: Order) -> Iterator[Shard]:
    """The shards that are there, to the byte; OutputError where the data set in the folder is another."""
    recorded = _recorded(order)
    if recorded is None:
        raise OutputError(
            f"{order.folder}: holds another data set: of another seed, number of maps, parameter or version of rsegen; "
            "give those of the run that was stopped, or another folder"
        )
    for shard in recorded:
        names = order.layout.names(shard.number)
        if all(part == measured(order.folder / names[what]) for what, part in shard.parts.items()):
            yield shard


def _recorded(order: Order) -> list[Shard] | None:
    if (order.folder / MANIFEST).is_file():
        layout, shards = read_manifest(order.folder)
        return shards if first_line(layout) == first_line(order.layout) else None
    return read_record(order.folder, order.layout) if (order.folder / RECORD).is_file() else []


@contextmanager
def _alone(path: Path) -> Iterator[TextIO]:
    """The record, which goes when all is done; an OutputError where another run has it, if the system can tell."""
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
    """Clear away what a killed run left half written; `everything`: the data set that stood there too, and no more."""
    names = os.listdir(folder)
    ours = [name for name in names if _HIDDEN.fullmatch(name) or (everything and _OURS.fullmatch(name))]
    for name in sorted(ours, key=lambda name: name != MANIFEST):
        os.unlink(folder / name)


def _finish(order: Order, there: dict[int, Shard], maker: _Maker, record: TextIO, progress: Progress | None) -> None:
    """Make the shards that are missing, with a line in the record for each; then the manifest takes its place."""
    layout = order.layout
    done, made = dict(there), maker(order, frozenset(there))
    try:
        record.truncate(0)
        record.write(first_line(layout) + "".join(next_line(layout, shard) for shard in there.values()))
        record.flush()
        with closing(made):
            for shard in made:
                record.write(next_line(layout, shard))
                record.flush()
                done[shard.number] = shard
                if progress:
                    progress(len(layout.places(shard.number)), already=False)
        write_file([manifest(layout, (done[number] for number in sorted(done)))], order.folder / MANIFEST, force=True)
    except BaseException:
        with suppress(OSError):
            _clear(order.folder, everything=not done)
            if not done:
                os.unlink(order.folder / RECORD)
        raise


_Maker = Callable[[Order, frozenset[int]], Generator[Shard, None, None]]


def _made(order: Order, there: frozenset[int], *, workers: int, scheduler: str | None) -> Generator[Shard, None, None]:
    """The shards that are not there, made by a cluster, by workers where that is quicker, or here."""
    left = [number for number in range(order.layout.shards) if number not in there]
    if scheduler is None or not left:
        return each(order, left, workers)
    return on_cluster(order.made, left, scheduler=scheduler, workers=min(workers, len(left), order.at_once))
