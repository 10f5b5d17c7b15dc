"""Children, measured one after the other.

Nothing heavy is imported here: Linux counts what a parent has in memory as its child's.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median
from time import perf_counter

import psutil

from benchmarks.figures import LACKING, Run
from benchmarks.ways import FOLDER, MATRICES, Command, Way

ROOT = Path(__file__).parents[1]

_ENVIRONMENT = {**os.environ, "PYTHONPATH": os.pathsep.join((str(ROOT / "src"), str(ROOT)))}

_ONE_THREAD = {**_ENVIRONMENT, "OPENBLAS_NUM_THREADS": "1"}
"""numpy's other threads do nothing here, but they wait busily at first, and that would be counted."""


_IN_MEMORY = Path("/dev/shm")  # noqa: S108  # a folder of our own is made in it
_ROOM = 8_000_000_000

SHELF = str(_IN_MEMORY) if _IN_MEMORY.is_dir() and psutil.disk_usage(str(_IN_MEMORY)).free > _ROOM else None
"""Folder of the files: in memory where that can be, for a disk's own cost varies more than anything measured."""


class Failed(Exception):  # a way that failed is a row of the table
    """A child ended without a figure; says why."""


def written(way: Way, size: int, python: str) -> Run:
    """One grid to a file."""
    room = str(psutil.virtual_memory().available * 3 // 4)
    with tempfile.TemporaryDirectory(dir=SHELF) as folder:
        path = str(Path(folder) / f"grid.{way.ending}")
        return _told([python, "-m", "benchmarks.child", room, way.module, way.function, str(size), path])


def commanded(command: Command) -> Run:
    """One whole program, its start included; bytes are those of all files that it wrote."""
    with tempfile.TemporaryDirectory(dir=SHELF) as folder:
        arguments = [folder if argument == FOLDER else argument for argument in command.arguments]
        started = perf_counter()
        child = subprocess.Popen(arguments, env=_ENVIRONMENT, stdout=subprocess.DEVNULL)
        _, status, used = os.wait4(child.pid, 0)
        wall = perf_counter() - started
        child.returncode = os.waitstatus_to_exitcode(status)
        if child.returncode:
            raise Failed(f"exit code {child.returncode}")
        return Run(cpu=used.ru_utime + used.ru_stime, wall=wall, rss=used.ru_maxrss * 1024, bytes=_size(folder))


def _size(folder: str) -> int:
    """Bytes of all files in it. Their names are not kept, for the next child would be told to have them."""
    return sum(os.stat(os.path.join(above, name)).st_size for above, _, names in os.walk(folder) for name in names)


def built(count: int) -> Run:
    """That many matrices in memory."""
    return _told([*MATRICES.arguments, str(count)])


def counted(seeds: int, sizes: list[int]) -> list[dict[str, object]]:
    """Faces of every kind of grid."""
    arguments = [sys.executable, "-m", "benchmarks.faces", str(seeds), *map(str, sizes)]
    found: list[dict[str, object]] = json.loads(_printed(arguments))
    return found


def middle(runs: list[Run]) -> Run:
    """The median of each figure by itself."""
    return Run(
        cpu=median(run.cpu for run in runs),
        wall=median(run.wall for run in runs),
        rss=int(median(run.rss for run in runs)),
        bytes=runs[0].bytes,
        faces=runs[0].faces,
    )


def _told(arguments: list[str]) -> Run:
    return Run(**json.loads(_printed(arguments)))


def _printed(arguments: list[str]) -> str:
    found = subprocess.run(arguments, cwd=ROOT, env=_ONE_THREAD, capture_output=True, text=True, check=False)
    if found.returncode == LACKING:
        raise Failed("not installed here")
    if found.returncode:
        raise Failed((found.stderr.strip().splitlines() or [f"exit code {found.returncode}"])[-1])
    return found.stdout.splitlines()[-1]
