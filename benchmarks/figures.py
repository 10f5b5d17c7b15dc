"""Measurements as frozen values and as JSON. Seconds and bytes."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

RESULTS = Path(__file__).parent / "results"

LACKING = 3
"""The exit code of a child whose library is not installed."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Run:
    """One child: seconds of CPU (user and system) and on the wall, peak resident bytes, bytes and faces written."""

    cpu: float
    wall: float
    rss: int
    bytes: int = 0
    faces: int = 0


@dataclass(frozen=True, kw_only=True, slots=True)
class Row:
    """Medians of the runs of one work: `size` blocks a side, `count` maps; `missing` says why there are none."""

    name: str
    title: str
    size: int
    count: int = 1
    runs: int = 0
    middle: Run | None = None
    missing: str = ""


@dataclass(frozen=True, kw_only=True, slots=True)
class Faces:
    """Mean faces of one kind of grid: six a box, exposed squares, merged by rsegen."""

    grid: str
    size: int
    seeds: int
    naive: float
    exposed: float
    merged: float


@dataclass(frozen=True, kw_only=True, slots=True)
class Results:
    """One run of the benchmarks: a grid to a file, whole commands, many maps, face counts."""

    machine: str
    plan: str
    writers: tuple[Row, ...] = ()
    commands: tuple[Row, ...] = ()
    faces: tuple[Faces, ...] = ()

    def middle(self, name: str, size: int) -> Run | None:
        """The medians of a work, where it was measured."""
        found = (row.middle for row in self.writers + self.commands if (row.name, row.size) == (name, size))
        return next(found, None)

    def rows(self, size: int) -> Iterator[Row]:
        """The ways to write a grid of one size."""
        return (row for row in self.writers if row.size == size)


def record_in(path: Path) -> Any:
    """Return the record in a file."""
    return json.loads(path.read_text("utf-8"))


def say(line: str) -> None:
    """Print a line on the progress of a benchmark."""
    print(line, file=sys.stderr, flush=True)


def keep(record: object, path: Path) -> None:
    """Write a record into its file."""
    path.write_text(json.dumps(record, indent=1) + "\n", "utf-8")


def saved(results: Results) -> str:
    """The results as JSON."""
    return json.dumps(asdict(results), indent=1) + "\n"


def loaded(path: Path) -> Results:
    """The results in a JSON file."""
    found = record_in(path)
    return Results(
        machine=found["machine"],
        plan=found["plan"],
        writers=tuple(map(_row, found["writers"])),
        commands=tuple(map(_row, found["commands"])),
        faces=tuple(Faces(**each) for each in found["faces"]),
    )


def _row(entry: dict[str, object]) -> Row:
    middle = entry.pop("middle")
    return Row(**entry, middle=Run(**middle) if isinstance(middle, dict) else None)  # type: ignore[arg-type]  # as saved
