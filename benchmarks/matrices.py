"""Matrices a second: `python -m benchmarks.matrices COUNT` builds that many maps of 10 x 10 random blocks in memory."""

from __future__ import annotations

import json
import resource
import sys
from dataclasses import asdict
from time import perf_counter, process_time

import rsegen
from benchmarks.figures import Run


def main(arguments: list[str]) -> None:
    """Measure, once warm."""
    (count,) = map(int, arguments)
    obstacle = rsegen.Random(levels=6)
    recipe = rsegen.Recipe(seed=1, boundary="none", obstacles=(obstacle,))
    rsegen.build(recipe, count)
    cpu, wall = process_time(), perf_counter()
    for index in range(count):
        rsegen.build(recipe, index)
    cpu, wall = process_time() - cpu, perf_counter() - wall
    rss = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    print(json.dumps(asdict(Run(cpu=cpu, wall=wall, rss=rss))))


if __name__ == "__main__":
    main(sys.argv[1:])
