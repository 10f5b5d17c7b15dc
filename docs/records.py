"""Origin of each record of benchmarks/results: when, on what machine, by what command and with which code it was made.

A record that has changed since the dates were written is of the day, and of the code, on which
`python -m docs.generate` sees it first: `make bench` and the like call it at once. So a date is that of the figures,
and not of a commit.

The state of the code is a checksum of each part that makes the figures, without comments and docstrings. Where it is
another one now, the figures are older than the code: `python -m docs.records` says which, and what has changed. What
makes the maps themselves is no part, as their bytes are held by tests/golden.
"""

from __future__ import annotations

import ast
import hashlib
import io
import json
import sys
import tokenize
from collections.abc import Iterator, Mapping
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from benchmarks.figures import RESULTS, record_in

DATES = RESULTS / "dates.json"
ROOT = Path(__file__).parents[1]

_DRIVES = ("src/rsegen/driving", "src/rsegen/robots", "src/rsegen/standing")
_IN_MUJOCO = (*_DRIVES, "src/rsegen/mujoco")
_IN_GAZEBO = (*_DRIVES, "src/rsegen/simulators", "src/rsegen/gazebo")
_TRIALS = ("src/rsegen/experiments", *_IN_GAZEBO, "src/rsegen/geometry")


class Source(NamedTuple):
    """The page that shows figures, the command that measures them again, and the files and folders that make them."""

    page: str
    command: str
    code: tuple[str, ...] = ()


SOURCES: Mapping[str, Source] = {
    "agreement": Source(
        "[simulators that agree](agreement.md)",
        "python -m benchmarks.agreement",
        ("benchmarks/agreement.py", "src/rsegen/simulators", *_IN_MUJOCO),
    ),
    "ant": Source(
        "[Gymnasium's Ant](learned.md)",
        "python -m benchmarks.ant_on_blocks",
        ("benchmarks/ant_on_blocks.py", "benchmarks/ant.py", "src/rsegen/learning"),
    ),
    "asked": Source(
        "[as surely as asked](constraints.md)",
        "python -m benchmarks.asked",
        ("benchmarks/asked.py", "src/rsegen/recipe/constraints", *_IN_MUJOCO),
    ),
    "burgers": Source("[at full speed](burgers.md)", "rsegen experiment burgers", _TRIALS),
    "busy": Source(
        "[busy machines](busy.md)", "python -m benchmarks.busy", ("benchmarks/busy.py", "src/rsegen/simulators")
    ),
    "certainty": Source(
        "[does it get across](predicted.md)", "python -m benchmarks.certainty", ("benchmarks/certainty.py", *_IN_MUJOCO)
    ),
    "contact": Source(
        "[what a wheel feels](contact.md)",
        "make bench-contact",
        ("benchmarks/contact", "src/rsegen/gazebo", "src/rsegen/geometry", "src/rsegen/simulators"),
    ),
    "contact-sim": Source(
        "[the same, Gazebo Sim](contact.md)",
        "python -m benchmarks.contact --simulator sim",
        (
            "benchmarks/contact",
            "src/rsegen/gazebo",
            "src/rsegen/geometry",
            "src/rsegen/robots/files/simulator_shapes.py",
            "src/rsegen/simulators",
        ),
    ),
    "crossable": Source(
        "[made for robots](constraints.md)",
        "python -m benchmarks.crossable",
        ("benchmarks/crossable.py", "src/rsegen/recipe/constraints", *_IN_MUJOCO),
    ),
    "crash": Source("[kills](reliability.md)", "make crash", ("tests/crash", "src/rsegen/writing")),
    "crossings": Source(
        "[robots across](poses.md)", "python -m benchmarks.crossings", ("benchmarks/crossings.py", *_IN_MUJOCO)
    ),
    "datasets": Source(
        "[data sets](datasets.md)",
        "python -m benchmarks.datasets",
        ("benchmarks/datasets.py", "src/rsegen/datasets", "src/rsegen/recipe/batch.py"),
    ),
    "driven": Source("[robots that drive](driven.md)", "rsegen experiment driven --simulator classic", _TRIALS),
    "driven_poses": Source(
        "[robots that drive](poses.md)",
        "python -m benchmarks.driven_poses",
        ("benchmarks/driven_poses.py", *_IN_MUJOCO),
    ),
    "experiment": Source("[the paper's experiment](experiment.md)", "make bench-experiment", _TRIALS),
    "fuzz": Source(
        "[hostile input](reliability.md)",
        "make fuzz",
        ("tests/fuzz", "src/rsegen/input_files.py", "src/rsegen/recipe", "src/rsegen/robots", "src/rsegen/scanning"),
    ),
    "learning": Source(
        "[other engines](learning.md)",
        "python -m benchmarks.learning",
        ("benchmarks/learning.py", "benchmarks/engines.py", "src/rsegen/learning"),
    ),
    "rating": Source(
        "[ratings of robots](rating.md)",
        "python -m benchmarks.rating",
        ("benchmarks/rating.py", "src/rsegen/rating", *_IN_MUJOCO),
    ),
    "representations": Source("[boxes and models](representations.md)", "rsegen experiment representations", _TRIALS),
    "flippers": Source(
        "[a crawler that learns](learned.md)",
        "python -m benchmarks.flippers",
        ("benchmarks/flippers.py", "src/rsegen/training", "src/rsegen/mujoco"),
    ),
    "go1": Source(
        "[mjlab's Go1](learned.md)",
        "python -m benchmarks.go1_on_blocks",
        ("benchmarks/go1_on_blocks.py", "src/rsegen/learning"),
    ),
    "many_worlds": Source(
        "[many worlds](learned.md)",
        "python -m benchmarks.many_worlds",
        ("benchmarks/many_worlds.py", "src/rsegen/mujoco"),
    ),
    "rests": Source(
        "[robots at rest](poses.md)",
        "python -m benchmarks.rests",
        ("benchmarks/rests.py", "src/rsegen/robots", "src/rsegen/standing", "src/rsegen/simulators"),
    ),
    "rooms": Source(
        "[scans of rooms](scan.md)",
        "python -m benchmarks.rooms",
        ("benchmarks/rooms.py", "benchmarks/depth_camera.py", "src/rsegen/scanning"),
    ),
    "scan": Source(
        "[scans](scan.md)",
        "python -m benchmarks.scan",
        ("benchmarks/scan.py", "benchmarks/depth_camera.py", "src/rsegen/scanning"),
    ),
    "speed": Source(
        "[speed and size](benchmarks.md)",
        "make bench",
        (
            "benchmarks/speed.py",
            "benchmarks/writers",
            "src/rsegen/geometry",
            "src/rsegen/gazebo",
            "src/rsegen/recipe/batch.py",
        ),
    ),
    "starts": Source("[starts](driving.md)", "python -m benchmarks.starts", ("benchmarks/starts.py", *_IN_GAZEBO)),
    "syncing": Source(
        "[waiting for the disk](reliability.md)",
        "python -m benchmarks.syncing",
        ("benchmarks/syncing.py", "src/rsegen/writing"),
    ),
    "training": Source(
        "[a robot that learns](training.md)",
        "python -m benchmarks.training",
        ("benchmarks/training.py", "src/rsegen/learning"),
    ),
}


def dates(today: str) -> dict[str, dict[str, Any]]:
    """Return the date, the checksum and the code of every record; of one that was changed since those of today."""
    known = record_in(DATES) if DATES.exists() else {}
    current = {}
    for path in records():
        checksum = hashlib.sha256(path.read_bytes()).hexdigest()
        entry = known.get(path.stem, {})
        if entry.get("sha256") != checksum:
            entry = {"date": today, "sha256": checksum}
        current[path.stem] = {"code": code_of(path.stem), **entry}  # that of today for one that came without
    return current


def code_of(name: str) -> dict[str, str]:
    """Return the checksum of each part of the code that makes a record, as it is now."""
    return {part: checksum_of(ROOT / part) for part in sorted(SOURCES[name].code if name in SOURCES else ())}


@cache
def checksum_of(part: Path) -> str:
    """Return eight digits of the checksum of a file or a folder of code."""
    files = (path for path in part.rglob("*") if path.is_file()) if part.is_dir() else filter(Path.is_file, [part])
    kept = (path for path in files if "__pycache__" not in path.parts)
    return checksum_of_files({path.relative_to(part.parent).as_posix(): path.read_bytes() for path in kept})


def checksum_of_files(contents: Mapping[str, bytes]) -> str:
    """Return eight digits of the checksum of files by their names; of Python without comments and docstrings."""
    found = hashlib.sha256()
    for name, content in sorted(contents.items()):
        code = without_comments(content.decode()) if name.endswith(".py") else content
        found.update(f"{name}\n{len(code)}\n".encode() + code)
    return found.hexdigest()[:8]


def without_comments(text: str) -> bytes:
    """Return the lines of a Python file without comments, docstrings, texts below names, and empty lines."""
    lines = text.splitlines()
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT:
            row, column = token.start
            lines[row - 1] = lines[row - 1][:column]
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            last = node.end_lineno or node.lineno
            if not lines[node.lineno - 1][: node.col_offset].strip():  # on lines of its own
                lines[node.lineno - 1 : last] = [""] * (last - node.lineno + 1)
    return "\n".join(line.rstrip() for line in lines if line.strip()).encode()


def older(dated: Mapping[str, Mapping[str, Any]]) -> dict[str, list[str]]:
    """Return the records that are older than the code that makes them, each with the parts that have changed."""
    found = {}
    for name, entry in dated.items():
        now, then = code_of(name), entry.get("code", {})
        if changed := [part for part in now if then.get(part) != now[part]]:
            found[name] = changed
    return found


def records() -> list[Path]:
    """Return the files of all records."""
    return sorted(path for path in RESULTS.glob("*.json") if path != DATES)


def today() -> str:
    """Return the date of today, UTC."""
    return datetime.now(UTC).date().isoformat()


def table(dated: Mapping[str, Mapping[str, Any]]) -> Iterator[str]:
    """A line of Markdown for every record."""
    yield "| figures | measured | code | command | on |"
    yield "|---|---|---|---|---|"
    aged = older(dated)
    for path in records():
        source = SOURCES.get(path.stem, Source(path.stem, ""))
        machine = _machine(record_in(path))
        code = f"{state(dated, path.stem)}{f', {OLDER}' * (path.stem in aged)}"
        yield f"| {source.page} | {dated[path.stem]['date']} | {code} | `{source.command}` | {machine} |"


OLDER = "changed since"
"""Mark of records that are older than the code that makes them."""


def state(dated: Mapping[str, Mapping[str, Any]], name: str) -> str:
    """Return the state of the code that a record was made with, in eight digits."""
    return hashlib.sha256(json.dumps(dated[name].get("code", {}), sort_keys=True).encode()).hexdigest()[:8]


def in_short(dated: Mapping[str, Mapping[str, Any]], *shown: str) -> Iterator[str]:
    """Yield, as Markdown, what the records that are shown were made with, and which of all are older than the code."""
    aged = older(dated)
    yield ""
    for name in shown:
        since = "which has changed since" if name in aged else "which is the code of today"
        yield f"Measured on {dated[name]['date']} with the code `{state(dated, name)}`, {since}."
    yield ""
    names = [f"{SOURCES[name].page}" for name in sorted(aged)]
    if not names:
        yield "No figures of this manual are older than the code that makes them."
        return
    which = f"{', '.join(names)}." if len(names) < len(dated) else "all of them."
    yield f"Of the {len(dated)} records of this manual {len(names)} are older than the code that makes them, so that"
    yield f"their commands may give other figures now: {which}"
    yield "`python -m docs.records` says what has changed."


def _machine(record: Any) -> str:
    """Words of a record on its machine; records of several shapes do so in several ways."""
    if isinstance(record, list):
        return ", ".join(dict.fromkeys(_machine(part) for part in record))
    machine = record.get("machine", "")
    if isinstance(machine, dict):
        machine = f"{machine['simulator']}; {machine['processor']}, {machine['cores']} cores, {machine['memory']}"
    simulator = record.get("simulator", "")
    python = f"Python {record['python']}" if "python" in record else ""
    return "; ".join(filter(None, (simulator if simulator not in machine else "", machine, python)))


def main() -> None:
    """Print every record that is older than the code that makes it, with what has changed."""
    dated = dates(today())
    for name, parts in older(dated).items():
        sys.stdout.write(f"{name}, {dated[name]['date']}: {', '.join(parts)} changed; {SOURCES[name].command}\n")


if __name__ == "__main__":
    main()
