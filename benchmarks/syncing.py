"""Cost of waiting until the disk has the files: the same maps with and without, in turns, in one process.

python -m benchmarks.syncing    the record in benchmarks/results/syncing.json, in a minute; docs/reliability.md shows it
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from statistics import median
from typing import Any

import rsegen
from benchmarks.figures import RESULTS
from benchmarks.machine import machine

FILE = RESULTS / "syncing.json"
_TURNS = 7
_RANDOM = rsegen.Recipe(seed=1, obstacles=(rsegen.Random(levels=5),))
_RUNS = {
    "1 map of 10 x 10 blocks": _RANDOM,
    "200 maps of 10 x 10 blocks": replace(_RANDOM, maps=200),
    "1 map of 320 x 320 blocks": replace(_RANDOM, chunks=(32, 32), boundary="none"),
    "20 maps of 80 x 80 blocks": replace(_RANDOM, chunks=(8, 8), maps=20),
}


def main() -> int:
    """Measure, print and keep."""
    found = {"machine": machine(), "rows": {name: _measured(recipe) for name, recipe in _RUNS.items()}}
    print("\n".join(table(found)))
    FILE.write_text(json.dumps(found, indent=2) + "\n", "utf-8")
    return 0


def table(found: Mapping[str, Any]) -> Iterator[str]:
    """The figures as lines of Markdown."""
    yield "| run | wall ms per map | with `--no-sync` | ratio |"
    yield "|---|---|---|---|"
    for name, row in found["rows"].items():
        yield f"| {name} | {row['sync_ms']:.2f} | {row['no_sync_ms']:.2f} | {row['ratio']:.2f} |"
    yield f"\nMedians of {_TURNS} turns of each, by `python -m benchmarks.syncing`, on: {found['machine']}."


def _measured(recipe: rsegen.Recipe) -> dict[str, float]:
    """Milliseconds per map with and without waiting, and the median of the ratios of neighbouring turns."""
    turns = [(_seconds(recipe, sync=True), _seconds(recipe, sync=False)) for _ in range(_TURNS)]
    with_, without = (median(column) / recipe.maps * 1000 for column in zip(*turns, strict=True))
    return {"sync_ms": with_, "no_sync_ms": without, "ratio": median(one / other for one, other in turns)}


def _seconds(recipe: rsegen.Recipe, *, sync: bool) -> float:
    with tempfile.TemporaryDirectory(prefix="rsegen-", dir=Path.cwd()) as folder:
        start = time.perf_counter()
        rsegen.generate(recipe, folder, sync=sync)
        return time.perf_counter() - start


if __name__ == "__main__":
    sys.exit(main())
