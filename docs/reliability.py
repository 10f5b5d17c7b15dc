"""The results of the trials of reliability, for the manual's chapter on it."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from benchmarks import syncing
from benchmarks.figures import RESULTS

FUZZ, CRASH = RESULTS / "fuzz.json", RESULTS / "crash.json"


def table() -> Iterator[str]:
    """The last results as lines of Markdown."""
    crash = _loaded(CRASH)
    tried = f"{crash['trials']:,} trials of {crash['commands']} commands, {crash['experiments']} kills of an experiment"
    yield "| trial | seed | tried | failed |"
    yield "|---|---|---|---|"
    for fuzz in _loaded(FUZZ):
        yield f"| `make fuzz` | {fuzz['seed']} | {fuzz['cases']:,} cases | {fuzz['fail']} |"
    yield f"| `make crash` | {crash['seed']} | {tried} | {crash['problems']} |"
    yield "\nWaiting for the disk costs:\n"
    yield from syncing.table(_loaded(syncing.FILE))


def _loaded(path: Path) -> Any:
    return json.loads(path.read_text("utf-8"))
