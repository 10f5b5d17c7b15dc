"""Shares cases among processes, and reports each sort of failure: how often, an example, and how to repeat it."""

from __future__ import annotations

import hashlib
import json
import os
import platform
import subprocess
import sys
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from threading import Lock
from typing import Any

from docs.records import today
from tests.fuzz.case import read_case

CORPUS = Path(__file__).parent / "corpus"
ROOT = Path(__file__).parents[2]
EVERY = 20
"""Seconds between two lines that say how far it is."""


def run(numbers: range, seed: int, processes: int, family: str | None, record: Path | None = None) -> int:
    """Run cases of a seed, and append how many failed to the list in a JSON file `record`; 1 if any fails."""
    print(f"seed {seed}, {len(numbers):,} cases", flush=True)  # noqa: T201
    report = Report(seed=seed, family=family)
    count = min(processes, len(numbers))
    with ThreadPoolExecutor(count) as pool:
        parts = [pool.submit(_share, numbers[part::count], report) for part in range(count)]
    for part in parts:
        part.result()
    report.end()
    if record:
        found = {"date": today(), "python": platform.python_version(), "family": family or "all", "seed": seed}
        found |= {"cases": report.done, "fail": report.sorts.total()}
        before = json.loads(record.read_text("utf-8")) if record.exists() else []
        record.write_text(json.dumps([*before, found], indent=2) + "\n", "utf-8")
    return int(bool(report.sorts))


def _share(numbers: range, report: Report) -> None:
    """Run some cases in a process; one that crashes or hangs is followed by another, which begins behind that case."""
    while numbers:
        process = _worker(numbers, report)
        assert process.stdout
        at = None
        for line in process.stdout:
            said = json.loads(line)
            at = int(said["at"])
            report.take(said)
        if process.wait() == 0:
            return
        if at is None:
            raise RuntimeError("a process of the fuzz run ended before its first case")
        report.take({"at": at, "sort": f"crash {process.returncode}", "detail": "the process ended", "case": ""})
        numbers = numbers[numbers.index(at) + 1 :]


def _worker(numbers: range, report: Report) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "tests.fuzz", "--worker", str(numbers.start), "--processes", str(numbers.step)]
    command += ["--cases", str(numbers.stop), "--seed", str(report.seed)]
    command += ["--family", report.family] if report.family else []
    own = os.environ | {"PYTHONHASHSEED": "0", "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=ROOT, env=own)


@dataclass
class Report:
    """Number of failures of each sort, with the first example; and number of cases that were run."""

    seed: int
    family: str | None
    sorts: Counter[str] = field(default_factory=Counter)
    examples: dict[str, str] = field(default_factory=dict)
    done: int = 0
    began: float = field(default_factory=time.monotonic)
    shown: float = field(default_factory=time.monotonic)
    lock: Any = field(default_factory=Lock)

    def take(self, said: dict[str, Any]) -> None:
        """Take what a process says of a case: that it begins, or how it failed."""
        with self.lock:
            if "sort" in said:
                self._add(said["sort"], said["detail"], said["case"], said["at"])
            else:
                self.done += 1
            if time.monotonic() - self.shown > EVERY:
                self.shown = time.monotonic()
                print(f"{self.done:,} cases, {self.sorts.total()} fail", flush=True)  # noqa: T201

    def _add(self, sort: str, detail: str, line: str, number: int) -> None:
        """Count a failure; the first case of its sort is kept."""
        self.sorts[sort] += 1
        if sort in self.examples:
            return
        again = f"--seed {self.seed} --number {number}" + (f" --family '{self.family}'" if self.family else "")
        if line:
            CORPUS.mkdir(exist_ok=True)
            name = f"{read_case(line).family.replace(' ', '-')}-{hashlib.sha256(sort.encode()).hexdigest()[:8]}.json"
            if not (CORPUS / name).exists():  # else it is another case of a failure that was mended once
                (CORPUS / name).write_text(f"{line}\n", "utf-8")
                again = f"--replay {(CORPUS / name).relative_to(ROOT)}"
        self.examples[sort] = f"{' '.join(detail.split())[:400]}\n    python -m tests.fuzz {again}"

    def end(self) -> None:
        """Print all of it."""
        for sort, count in self.sorts.most_common():
            print(f"{count} x {sort}\n    {self.examples[sort]}")  # noqa: T201
        minutes = (time.monotonic() - self.began) / 60
        print(f"{self.sorts.total()} of {self.done:,} cases fail, seed {self.seed}, {minutes:.1f} min")  # noqa: T201
