"""Faces on every kind of grid: `python -m benchmarks.faces SEEDS SIZE...` prints them as JSON.

Naive: six a block. Exposed: a rectangle a top and a height difference. Merged: rsegen's surface. None of the last two
has a face at the ground.
"""

from __future__ import annotations

import json
import sys
from dataclasses import asdict

import numpy as np

from benchmarks.figures import Faces
from benchmarks.grids import GRIDS, Levels
from benchmarks.writers.ours import merged


def counted(grid: str, size: int, seeds: int) -> Faces:
    """Means over as many grids of one kind, fewer of the large ones."""
    seeds = min(seeds, 6 if size <= 80 else 2)
    drawn = [GRIDS[grid](size, seed) for seed in range(1, seeds + 1)]
    return Faces(
        grid=grid,
        size=size,
        seeds=seeds,
        naive=6.0 * size * size,
        exposed=float(np.mean([exposed(levels) for levels in drawn])),
        merged=float(np.mean([merged(levels) for levels in drawn])),
    )


def exposed(levels: Levels) -> int:
    """Tops, and pairs of neighbours at two heights; round the grid is the ground."""
    around = np.pad(levels, 1)
    return levels.size + sum(int(np.count_nonzero(np.diff(around, axis=axis))) for axis in (0, 1))


def main(arguments: list[str]) -> None:
    """Count, and print."""
    seeds, *sizes = map(int, arguments)
    print(json.dumps([asdict(counted(grid, size, seeds)) for size in sizes for grid in GRIDS]))


if __name__ == "__main__":
    main(sys.argv[1:])
