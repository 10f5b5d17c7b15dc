"""The results of the trials of reliability, for the manual's chapter on it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from benchmarks import syncing
from benchmarks.figures import RESULTS, record_in

FUZZ, CRASH = RESULTS / "fuzz.json", RESULTS / "crash.json"


def table() -> Iterator[str]:
    """The last results as lines of Markdown."""
    crash = record_in(CRASH)
    disks, experiments = crash["disks"], crash["experiments"]
    yield "| trial | date | seed | tried | failed |"
    yield "|---|---|---|---|---|"
    for fuzz in record_in(FUZZ):
        family = fuzz.get("family", "all")
        command = "`make fuzz`" if family == "all" else f"`python -m tests.fuzz --family {family}`"
        cells = fuzz["date"], f"{fuzz['seed']}", f"{fuzz['cases']:,} {_CASES[family]}", f"{fuzz['fail']}"
        yield f"| {command} | {' | '.join(cells)} |"
    for date, seed in dict.fromkeys((disk["date"], disk["seed"]) for disk in disks.values()):
        those = [disk for disk in disks.values() if (disk["date"], disk["seed"]) == (date, seed)]
        tried, failed = (_sum(those, what) for what in ("tried", "failed"))
        what = f"{tried:,} trials of {max(disk['commands'] for disk in those)} commands on {len(those)} disks"
        yield f"| `make crash` | {date} | {seed} | {what} | {failed} |"
    kills = f"{experiments['tried']} kills of an experiment in Gazebo | {experiments['failed']}"
    yield f"| `python -m tests.crash --experiments` | {experiments['date']} | {experiments['seed']} | {kills} |"
    yield "\nTrials of `make crash` by what happens, and by disk (failed / tried):\n"
    yield from _by_disk(disks)
    yield from (f"\nNot tried on {disk}: {why}." for disk, why in crash["skipped"].items() if disk not in disks)
    yield "\nWaiting for the disk costs:\n"
    yield from syncing.table(record_in(syncing.FILE))


_CASES = {
    "all": "cases",
    "wire": "conversations with a Gazebo that damages messages",
    "page": "conversations with the page's server, of more than 50 calls each",
    "field": "clouds of fields",
}
"""Cases of each family of tests/fuzz that is tried by itself, in words."""

_KINDS = {
    "kill": "killed before a call",
    "killafter": "killed after a call",
    "power": "power failure",
    "fail": "a call fails",
    "full": "the disk is full",
    "short": "a write is cut short",
    "interrupt": "Ctrl-C",
    "stuck": "renames fail from a call on",
    "dead": "all calls fail from one on",
    "second run": "a second run in the folder",
    "foreign in its place": "a thing of others in the place",
    "foreign hidden name": "a thing of others with a hidden name",
}
"""Events of trials of tests/crash, in words."""


def _sum(disks: Iterable[Mapping[str, Any]], what: str) -> int:
    return sum(count[what] for disk in disks for count in disk["counts"].values())


def _by_disk(disks: Mapping[str, Mapping[str, Any]]) -> Iterator[str]:
    """A table of trials: a row for each kind, a column for each disk."""
    yield f"| what happens | {' | '.join(disks)} |"
    yield f"|---|{'---|' * len(disks)}"
    for kind, words in _KINDS.items():
        cells = [disk["counts"].get(kind, {"tried": 0, "failed": 0}) for disk in disks.values()]
        shares = [f"{cell['failed']} / {cell['tried']}" for cell in cells]
        yield f"| {words} | {' | '.join(shares)} |"
