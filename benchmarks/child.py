"""One work in a program of its own: `python -m benchmarks.child ROOM MODULE FUNCTION SIZE FILE` prints what it took.

The library is imported and the grid made before the clock starts; peak memory is that of the whole program. ROOM is how
many bytes of address space it may take, so that one way's hunger is its own failure.
"""

from __future__ import annotations

import importlib
import json
import resource
import sys
from dataclasses import asdict
from pathlib import Path
from time import perf_counter, process_time

from benchmarks.figures import LACKING, Run
from benchmarks.grids import uniform


def main(arguments: list[str]) -> int:
    """Measure one work."""
    room, module, function, size, path = arguments
    resource.setrlimit(resource.RLIMIT_AS, (int(room), int(room)))
    try:
        write = getattr(importlib.import_module(f"benchmarks.writers.{module}"), function)
    except ModuleNotFoundError:
        return LACKING
    grid, file = uniform(int(size)), Path(path)
    cpu, wall = process_time(), perf_counter()
    faces = write(grid, file)
    cpu, wall = process_time() - cpu, perf_counter() - wall
    rss = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    print(json.dumps(asdict(Run(cpu=cpu, wall=wall, rss=rss, bytes=file.stat().st_size, faces=faces))))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
