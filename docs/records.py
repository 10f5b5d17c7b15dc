"""When, on what machine and by what command each record of benchmarks/results was made, for the manual.

A record that has changed since the dates were written is of the day on which `python -m docs.generate` sees it first:
`make bench` and the like call it at once. So a date is that of the figures, and not of a commit.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, NamedTuple

from benchmarks.figures import RESULTS

DATES = RESULTS / "dates.json"


class Source(NamedTuple):
    """Where figures are shown, and the command that measures them again."""

    page: str
    command: str


SOURCES: Mapping[str, Source] = {
    "agreement": Source("[MuJoCo and Gazebo Classic](mujoco.md)", "python -m benchmarks.agreement"),
    "burgers": Source("[at full speed](burgers.md)", "rsegen experiment burgers"),
    "busy": Source("[busy machines](busy.md)", "python -m benchmarks.busy"),
    "certainty": Source("[does it get across](certainty.md)", "python -m benchmarks.certainty"),
    "contact": Source("[what a wheel feels](contact.md)", "make bench-contact"),
    "contact-sim": Source("[the same, Gazebo Sim](contact.md)", "make bench-contact"),
    "crossable": Source("[made for robots](constraints.md)", "python -m benchmarks.crossable"),
    "crash": Source("[kills](reliability.md)", "make crash"),
    "crossings": Source("[robots across](poses.md)", "python -m benchmarks.crossings"),
    "datasets": Source("[data sets](datasets.md)", "python -m benchmarks.datasets"),
    "driven": Source("[robots that drive](driven.md)", "rsegen experiment driven --simulator classic"),
    "experiment": Source("[the paper's experiment](experiment.md)", "make bench-experiment"),
    "fuzz": Source("[hostile input](reliability.md)", "make fuzz"),
    "learning": Source("[other engines](learning.md)", "python -m benchmarks.learning"),
    "rating": Source("[ratings of robots](rating.md)", "python -m benchmarks.rating"),
    "representations": Source("[boxes and models](representations.md)", "rsegen experiment representations"),
    "rests": Source("[robots at rest](poses.md)", "python -m benchmarks.rests"),
    "scan": Source("[scans](scan.md)", "python -m benchmarks.scan"),
    "speed": Source("[speed and size](benchmarks.md)", "make bench"),
    "starts": Source("[starts](driving.md)", "python -m benchmarks.starts"),
    "syncing": Source("[waiting for the disk](reliability.md)", "python -m benchmarks.syncing"),
    "training": Source("[a robot that learns](training.md)", "python -m benchmarks.training"),
}


def dates(today: str) -> dict[str, dict[str, str]]:
    """Return the date and checksum of every record; one that was changed since is of today."""
    known = json.loads(DATES.read_text("utf-8")) if DATES.exists() else {}
    current = {}
    for path in records():
        checksum = hashlib.sha256(path.read_bytes()).hexdigest()
        entry = known.get(path.stem, {})
        current[path.stem] = entry if entry.get("sha256") == checksum else {"date": today, "sha256": checksum}
    return current


def records() -> list[Path]:
    """Return the files of all records."""
    return sorted(path for path in RESULTS.glob("*.json") if path != DATES)


def today() -> str:
    """Return the date of today, UTC."""
    return datetime.now(UTC).date().isoformat()


def table(dated: Mapping[str, Mapping[str, str]]) -> Iterator[str]:
    """A line of Markdown for every record."""
    yield "| figures | measured | command | on |"
    yield "|---|---|---|---|"
    for path in records():
        source = SOURCES.get(path.stem, Source(path.stem, ""))
        machine = _machine(json.loads(path.read_text("utf-8")))
        yield f"| {source.page} | {dated[path.stem]['date']} | `{source.command}` | {machine} |"


def _machine(record: Any) -> str:
    """What a record says of its machine; records of several shapes do so in several ways."""
    if isinstance(record, list):
        return ", ".join(dict.fromkeys(_machine(part) for part in record))
    machine = record.get("machine", "")
    if isinstance(machine, dict):
        machine = f"{machine['simulator']}; {machine['processor']}, {machine['cores']} cores, {machine['memory']}"
    simulator = record.get("simulator", "")
    python = f"Python {record['python']}" if "python" in record else ""
    return "; ".join(filter(None, (simulator if simulator not in machine else "", machine, python)))
