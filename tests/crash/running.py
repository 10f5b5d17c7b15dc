"""Runs trials in a few threads, each with a driver of its own, and collects what is wrong."""

from __future__ import annotations

import os
import queue
import shutil
import tempfile
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from itertools import product
from pathlib import Path

from tests.crash.commands import RUNS, TURNS, made_inputs
from tests.crash.disks import Disk
from tests.crash.injection import compiled
from tests.crash.server import Server
from tests.crash.trials import Trial, Undisturbed, problems, undisturbed

_SPACE = 2**29

OWN, OWN_ASIDE = "local, exchange", "local, no exchange"
"""This machine's own disk, as it is, and without the call that exchanges two names."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Problem:
    """One thing that is wrong after a trial."""

    number: int
    run: str
    kind: str
    disk: str
    done: str
    line: str

    def __str__(self) -> str:
        return f"{self.number} on {self.disk} ({self.run}; {self.done}): {self.line}"


@dataclass(frozen=True, kw_only=True, slots=True)
class Tried:
    """One trial on one disk, and what is wrong after it."""

    kind: str
    disk: str
    problems: tuple[Problem, ...]


def numbers(trials: int, only: str = "") -> list[int]:
    """The numbers of the first trials of commands whose names contain a text."""
    matching = [number for number, run in enumerate(TURNS) if only in run.name]
    if not matching:
        raise SystemExit(f"no command has {only!r} in its name: {', '.join(run.name for run in RUNS)}")
    return [len(TURNS) * (i // len(matching)) + matching[i % len(matching)] for i in range(trials)]


class Trials:
    """Trials of a seed, in a folder of their own, on a disk: this machine's own, or another one that is mounted."""

    def __init__(self, seed: int, folder: Path, servers: queue.Queue[Server], disk: Disk | None) -> None:
        self._seed, self._folder, self._servers, self._disk = seed, folder, servers, disk
        self._alone: dict[tuple[str, bool, bool], Undisturbed] = {}
        kinds = product((run.name for run in RUNS), (False, True), (False, True))
        self._locks = {kind: threading.Lock() for kind in kinds}

    def tried(self, number: int) -> list[Tried]:
        """One trial, made on a disk that exchanges two names at once, and on one that cannot; on another disk once."""
        tried = []
        server = self._servers.get()
        try:
            for exchanges in (True,) if self._disk else (True, False):
                trial = Trial.drawn(self._seed, number, exchanges=exchanges, disk=self._disk)
                server.lacks = trial.lacks
                done, lines = problems(trial, self._undisturbed(trial, server), server)
                name, kind = trial.run.name, trial.kind
                disk = self._disk.name if self._disk else OWN if exchanges else OWN_ASIDE
                found = [Problem(number=number, run=name, kind=kind, disk=disk, done=done, line=line) for line in lines]
                tried.append(Tried(kind=kind, disk=disk, problems=tuple(found)))
        finally:
            self._servers.put(server)
        return tried

    def _undisturbed(self, trial: Trial, server: Server) -> Undisturbed:
        run, key = trial.run, (trial.run.name, trial.shared, trial.exchanges)
        with self._locks[key]:
            if key not in self._alone:
                folder = self._folder / f"{len(self._alone)}-{RUNS.index(run)}-{trial.shared}"
                self._alone[key] = undisturbed(run, server, folder, shared=trial.shared)
            return self._alone[key]


def _memory() -> str | None:
    """A disk in memory, which does not wait for what others write; None if there is none with some space."""
    folder = "/dev/shm"  # noqa: S108  # a folder with a random name is made in it
    enough = os.access(folder, os.W_OK) and shutil.disk_usage(folder).free > _SPACE
    return folder if enough else None


@contextmanager
def trials(seed: int, processes: int, disk: Disk | None = None) -> Iterator[Trials]:
    """Trials of a seed, with so many drivers that run them; NotMounted if their disk cannot be mounted."""
    with ExitStack() as stack:
        above = stack.enter_context(disk.mounted()) if disk else _memory()
        name = stack.enter_context(tempfile.TemporaryDirectory(prefix="rsegen-crash-", dir=above))
        control = stack.enter_context(tempfile.TemporaryDirectory(prefix="rsegen-crash-", dir=_memory()))
        folder = Path(name).resolve()
        library, inputs = compiled(Path(control)), made_inputs(folder / "inputs")
        servers: queue.Queue[Server] = queue.Queue()
        for i in range(processes):
            servers.put(stack.enter_context(Server(folder / f"server-{i}", Path(control, str(i)), library, inputs)))
        (folder / "alone").mkdir()
        yield Trials(seed, folder / "alone", servers, disk)


def run(
    seed: int,
    those: Sequence[int],
    processes: int,
    heard: Callable[[int, list[Problem]], object],
    disk: Disk | None = None,
) -> list[Tried]:
    """Trials on a disk; `heard` is called after each with the number of those that are done, and its problems."""
    tried: list[Tried] = []
    with trials(seed, processes, disk) as made, ThreadPoolExecutor(processes) as pool:
        for done, new in enumerate(pool.map(made.tried, those), 1):
            tried += new
            heard(done, [problem for each in new for problem in each.problems])
    return tried
