"""Runs a task for many items, here or, if that is quicker, in workers: always in order, each map whole or not at all.

RunPlan --run--> the result of each map, in order
"""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Callable, Generator, Iterable, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, Protocol, TypeVar

from rsegen.io.resources import Needs
from rsegen.io.staging import as_write_errors, parents_made, remove_leftovers
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


def cores() -> int:
    """How many cores this process may use."""
    return len(os.sched_getaffinity(0)) if sys.platform == "linux" else os.cpu_count() or 1


class Task(Protocol[Item_contra, Made_co]):
    """What to do for each of many items: all that a worker needs to know, except which items are its own."""

    @property
    def seconds(self) -> float:
        """About how long one item takes; decides how the items are divided among workers, never the result."""

    def __call__(self, items: Iterable[Item_contra], /) -> Sequence[Made_co]:
        """The results of some items."""


@dataclass(frozen=True, kw_only=True, slots=True)
class RunPlan(Generic[Item, Made]):
    """What a run will make, how, what exists already and stays, and what it needs; nothing prevents it any more.

    task: how a map is made   to_make: the maps, in order
    existing: maps that exist and are kept   workers: how many processes take part, at the most
    homes: folders besides `folder` in which a killed run may have left something
    """

    folder: Path
    task: Task[Item, Made]
    to_make: Sequence[Item]
    existing: Sequence[Item] = ()
    needs: Needs
    workers: int
    homes: Sequence[Path] = ()


def run(plan: RunPlan[Item, Made], progress: Callable[[Made], object] | None = None) -> tuple[Made, ...]:
    """Make the maps of a plan; `progress` is called with the result of each."""
    done = []
    with closing(_results(plan)) as results:
        for result in results:
            done.append(result)
            if progress:
                progress(result)
    return tuple(done)


def run_each(task: Task[Item, Made], items: Sequence[Item], workers: int) -> Generator[Made, None, None]:
    """The results of the items in their order, made here or, if that is quicker, by workers."""
    workers = min(workers, len(items))
    if not items:
        return
    if workers <= 1 or len(items) * task.seconds < WORTHWHILE:
        batch = max(1, math.ceil(BATCH / task.seconds))
        for start in range(0, len(items), batch):
            yield from task(items[start : start + batch])
        return
    from rsegen.io.workers import run_in_workers  # multiprocessing takes longer to import than a small map to make

    batch = math.ceil(min(BATCH / task.seconds, len(items) / workers / 4))
    yield from run_in_workers(task, items, batch=batch, workers=workers)


def _results(plan: RunPlan[Item, Made]) -> Generator[Made, None, None]:
    """The results one by one; what killed runs left half done, and workers that are killed, is removed."""
    for folder in (plan.folder, *plan.homes):
        remove_leftovers(folder)
    with as_write_errors(plan.folder), parents_made(plan.folder / "map"):
        try:
            yield from run_each(plan.task, plan.to_make, plan.workers)
        except BaseException:
            remove_leftovers(plan.folder)
            raise
