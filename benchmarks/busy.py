"""Commands for a running Gazebo Classic on a busy machine: how many fail, and how long they take.

python -m benchmarks.busy    prints the table and keeps benchmarks/results/busy.json; half an hour

So many programs that do nothing but work compete with the server and with the commands, each of which is a process of
its own, as in a shell. A command that ends with another exit code than 0 is a miss.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import median
from typing import Any

from benchmarks.figures import RESULTS, keep
from benchmarks.machine import machine
from rsegen.simulators.base import SIMULATORS, Installation
from rsegen.simulators.server import running_server
from rsegen.writing.target_worlds import world_of

FILE = RESULTS / "busy.json"
LOADS = (0, 10, 50)
TRIES = 2
COURSE = "mixed-course"
COMMANDS: Mapping[str, Sequence[str]] = {
    "open": ("open", COURSE, "--headless", "--seconds", "1"),
    "spawn": ("spawn", "burger", "--name", "robot"),
    "respawn": ("respawn", COURSE),
    "remove": ("remove", "robot"),
    "drive": ("drive", COURSE, "--robot", "jackal", "--duration", "1", "--seed", "1"),
}
"""Those that a try has, in this order: the world of the running server has the map of the course, and no robot."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Tried:
    """A command that was tried with so many programs beside it: its seconds on the wall; its error, empty for none."""

    load: int
    command: str
    seconds: float
    error: str


@contextmanager
def busy(programs: int) -> Iterator[None]:
    """Run a number of programs that work and never end."""
    with ExitStack() as stack:
        for _ in range(programs):
            program = subprocess.Popen([sys.executable, "-c", "while True: pass"])
            stack.callback(program.wait)
            stack.callback(program.kill)
        yield


def tries(here: Installation, load: int) -> Iterator[Tried]:
    """Try each command with so many programs beside it."""
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        file = stack.enter_context(world_of(COURSE).on_disk())
        server = stack.enter_context(running_server(here, file))
        with server.connect() as live:
            live.unpause()
        stack.enter_context(busy(load))
        for _ in range(TRIES):
            for name, words in COMMANDS.items():
                yield _tried(load, name, [*words, "--simulator", "classic"], folder, server.environment)


def _tried(load: int, name: str, words: Sequence[str], folder: Path, variables: Mapping[str, str]) -> Tried:
    began = time.monotonic()
    command = [sys.executable, "-m", "rsegen", *words]
    done = subprocess.run(
        command, capture_output=True, text=True, cwd=folder, env=os.environ | dict(variables), check=False
    )
    error = (done.stderr.strip().splitlines() or [f"exit code {done.returncode}"])[-1] if done.returncode else ""
    return Tried(load=load, command=name, seconds=round(time.monotonic() - began, 1), error=error)


def main(arguments: Sequence[str] | None = None) -> int:
    """Try all, and keep the record."""
    asked = argparse.ArgumentParser(prog="python -m benchmarks.busy", description=__doc__.splitlines()[0])
    asked.add_argument("--only-print", action="store_true", help="keep no record")
    said = asked.parse_args(arguments)
    here = SIMULATORS["classic"].installation()
    if not here:
        print("no Gazebo Classic: run scripts/gazebo-classic", file=sys.stderr)
        return 2
    record: dict[str, Any] = {"machine": f"{here}; {machine()}", "tries": []}
    for load in LOADS:
        for tried in tries(here, load):
            print(tried, file=sys.stderr)
            record["tries"].append(asdict(tried))
    if not said.only_print:
        keep(record, FILE)
    print(page(record))
    return 0


def page(record: Mapping[str, Any]) -> str:
    """Return the record as a page of the manual."""
    tried = [Tried(**each) for each in record["tries"]]
    return (
        "\n".join(
            [
                *_INTRODUCTION,
                *_rows(tried),
                "",
                f"By `python -m benchmarks.busy`, on: {record['machine']}.",
                *_misses(tried),
            ]
        )
        + "\n"
    )


_INTRODUCTION = (
    "# Busy machines",
    "",
    "Commands for Gazebo Classic while other programs do nothing but compete for the processors: how many of",
    f"{TRIES} fail, and the median of their seconds. `open` loads `mixed-course`, waits for its clock, and ends a",
    "second later; `drive` simulates a second; `spawn`, `respawn` and `remove` change a running server. A simulator is",
    "waited for as long as it makes progress ([how](algorithms.md)); `--timeout`, 20 s by default, says how long",
    "without.",
    "",
)


def _rows(tried: Sequence[Tried]) -> Iterator[str]:
    """Yield a row for each command, with a column for each load."""
    loads = list(dict.fromkeys(each.load for each in tried))
    yield "| misses; seconds | " + " | ".join(f"{load} programs" if load else "quiet" for load in loads) + " |"
    yield "|---|" + "---|" * len(loads)
    for command in dict.fromkeys(each.command for each in tried):
        cells = ([each for each in tried if (each.command, each.load) == (command, load)] for load in loads)
        yield f"| `{command}` | " + " | ".join(map(_cell, cells)) + " |"


def _misses(tried: Sequence[Tried]) -> Iterator[str]:
    """Yield what each command that failed has said."""
    for each in tried:
        if each.error:
            yield f"\n`{each.command}` beside {each.load} programs: {each.error}"


def _cell(tried: Sequence[Tried]) -> str:
    misses = sum(bool(each.error) for each in tried)
    return f"{misses}; {median(each.seconds for each in tried):.1f}"


if __name__ == "__main__":
    sys.exit(main())
