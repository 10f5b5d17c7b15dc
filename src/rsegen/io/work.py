"""What is done for each of many: here or, where that is quicker, by workers; always in order, and whole or not at all.

items --Work--> what comes of each of them
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Iterable, Sequence
from contextlib import closing
from pathlib import Path
from typing import Protocol, TypeVar

from rsegen.io.workers import run_in_workers
from rsegen.io.writer import as_write_errors, parents_made, remove_leftovers
from rsegen.params.sorts import Integer

WORTHWHILE = 1.0
"""Seconds of work from which on workers gain more than they cost."""

BATCH = 0.2
"""Seconds of work that a worker is given at once: much more than the giving takes, little enough to see it move."""

WORKERS = Integer(1, help="processes that make maps at the same time")

Item = TypeVar("Item")
Item_contra = TypeVar("Item_contra", contravariant=True)
Made = TypeVar("Made")
Made_co = TypeVar("Made_co", covariant=True)


class Task(Protocol[Item_contra, Made_co]):
    """What is done for each of many items: all that a worker is told, but which of them are its own."""

    @property
    def seconds(self) -> float:
        """About how long one takes; it decides how the work is shared out, not what comes of it."""

    @property
    def at_once(self) -> int:
        """How many fit into memory together."""

    def __call__(self, items: Iterable[Item_contra], /) -> Sequence[Made_co]:
        """What comes of some of them."""


class MapTask(Task[Item_contra, Made_co], Protocol[Item_contra, Made_co]):
    """Work that puts a map into a folder for each item."""

    @property
    def folder(self) -> Path:
        """Where the maps go."""

    def map_name(self, item: Item_contra, /) -> str:
        """What the map of an item is called."""


def run_each(work: Task[Item, Made], items: Sequence[Item], workers: int) -> Generator[Made, None, None]:
    """What comes of the items, made here or, where that is quicker, by workers."""
    workers = min(workers, len(items), work.at_once)
    if workers <= 1 or len(items) * work.seconds < WORTHWHILE:
        for item in items:
            yield from work([item])
        return
    batch = math.ceil(min(BATCH / work.seconds, len(items) / workers / 4))
    yield from run_in_workers(work, items, batch=batch, workers=workers)


def run_in_order(
    work: MapTask[Item, Made], items: Sequence[Item], workers: int, progress: Callable[[Made], object] | None
) -> tuple[Made, ...]:
    """What comes of the items, on disk; `progress` is told of each that is done."""
    done = []
    with closing(_whole(work, items, workers)) as found:
        for one in found:
            done.append(one)
            if progress:
                progress(one)
    return tuple(done)


def _whole(work: MapTask[Item, Made], items: Sequence[Item], workers: int) -> Generator[Made, None, None]:
    """The same one by one; what a worker leaves that is killed goes."""
    with as_write_errors(work.folder), parents_made(work.folder / "map"):
        try:
            yield from run_each(work, items, workers)
        except BaseException:
            remove_leftovers(work.folder, lambda name: name in map(work.map_name, items))
            raise
