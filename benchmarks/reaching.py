"""`python -m benchmarks.reaching --against DIR`: what it costs to find where robots get, and that the verdicts stay.

DIR is the folder `src` of another version of rsegen. Both versions find, in fresh children, all moves and turns of
robots on fields of fresh seeds, what they reach there and on the example mixed-course, and the shortest ways. What
differs is counted, and the CPU time of the other version is divided by that of this one. `--robot FILE` adds a robot.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

FIELDS = {"burger": (0.3, 0.5, 1.0, 2.0), "jackal": (1.0, 2.0, 3.0, 5.0), "crawler": (2.0, 3.0, 5.0, 10.0)}
"""Units of the fields of each robot, centimetres: from those that it crosses to those that hardly let it move."""
SEEDS = (9100, 9101, 9102)
COURSE = "mixed-course"
_SOURCE = Path(__file__).parent.parent / "src"


def cases(robots: list[str]) -> Iterator[tuple[str, float, int]]:
    """Yield robots with a unit and a seed, or 0 and 0 for the course."""
    yield from ((robot, unit, seed) for robot, units in FIELDS.items() for unit in units for seed in SEEDS)
    yield from ((robot, 0.0, 0) for robot in (*FIELDS, *robots))


def judged(robot: str, unit: float, seed: int) -> dict[str, Any]:
    """Return the verdicts on a robot, and the CPU seconds of `reach`."""
    import rsegen
    from rsegen.recipe.examples import EXAMPLES
    from rsegen.standing.lattice import Lattice
    from rsegen.standing.reach import reach

    if unit:
        recipe = rsegen.Recipe(seed=seed, unit_cm=unit, boundary="none", obstacles=[rsegen.NormalRandom(levels=5)])
    else:
        recipe = rsegen.load(EXAMPLES[COURSE])
    field, body = rsegen.build(recipe), rsegen.robot_of(robot).body
    began = time.process_time()
    found = reach(field, body)
    seconds = time.process_time() - began
    lattice = Lattice(field, body)
    every = np.arange(lattice.moves.size if unit else 0)  # of the course it would take as long again
    lattice.drive_from(every)
    lattice.turn_at(every)
    ways = [way.length if way.crosses else np.inf for way in (found.west_east, found.south_north)]
    lines = [np.round(way.points, 6).ravel() for way in (found.west_east, found.south_north)]
    return {
        "seconds": seconds,
        "moves": lattice.moves[lattice.is_driven],
        "turns": lattice.turns[lattice.is_turned],
        "region": found.region,
        "ways": np.round(np.array(ways, float), 6),
        "line": np.concatenate(lines),
        "tilt": np.round([way.tilt or 0.0 for way in (found.west_east, found.south_north)], 6),
    }


def main(arguments: list[str]) -> int:
    """Compare two versions, case by case."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.reaching")
    parser.add_argument("--against", type=Path, metavar="DIR", help="the folder src of another version")
    parser.add_argument("--robot", action="append", default=[], metavar="FILE", help="one more, on the course alone")
    parser.add_argument("--case", nargs=4, metavar=("ROBOT", "UNIT", "SEED", "FILE"), help=argparse.SUPPRESS)
    given = parser.parse_args(arguments)
    if given.case:
        robot, unit, seed, file = given.case
        np.savez(file, **judged(robot, float(unit), int(seed)))
        return 0
    versions = [version for version in (given.against, _SOURCE) if version]
    counts: dict[str, np.ndarray[Any, Any]] = {}
    for case in cases(given.robot):
        results = [_in_child(version, *case) for version in versions]
        print(*case, *(f"{result['seconds']:.2f} s" for result in results), end="")
        if given.against:
            other, own = results
            print(f" ratio {float(other['seconds'] / own['seconds']):.2f}", end="")
            for name in sorted(set(own) - {"seconds"}):
                alike = own[name].shape == other[name].shape
                differing = np.array([int((own[name] != other[name]).sum()) if alike else 1, own[name].size])
                counts[name] = counts.get(name, np.zeros(2, int)) + differing
                if differing[0]:
                    print(f", {differing[0]} of {differing[1]} {name} differ", end="")
        print(flush=True)
    for name, (differing, count) in counts.items():
        print(f"{name}: {differing} of {count} differ")
    return 0


def _in_child(source: Path, robot: str, unit: float, seed: int) -> dict[str, Any]:
    """Return what a version of rsegen finds."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "found.npz"
        case = ["--case", robot, str(unit), str(seed), str(file)]
        environment = {**os.environ, "PYTHONPATH": str(source)}
        subprocess.run([sys.executable, "-m", "benchmarks.reaching", *case], env=environment, check=True)
        with np.load(file) as arrays:
            return dict(arrays)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
