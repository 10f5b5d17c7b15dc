"""Hostile input for every reader and every command: python -m tests.fuzz --cases 100000 --seed 7.

Cases are made from a seed and a number, so a seed stands for the same cases again. Each that fails is made as small as
it can be and kept in corpus/, from where tests/fuzz/test_fuzz.py runs it ever after.

    --cases N       how many (default: 3000)            --seed S      which (default: drawn and printed)
    --processes N   at the same time (default: 2)       --family F    of one sort of input alone
    --number K      case K of the seed alone            --replay F    the case in a file of corpus/
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import random
import selectors
import subprocess
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO

from tests.fuzz.case import Case, read_case
from tests.fuzz.families import FAMILIES, case_of

CORPUS = Path(__file__).parent / "corpus"
ROOT = Path(__file__).parents[2]
SILENCE = 180
"""Seconds without a word after which a process hangs."""


def main(arguments: Sequence[str]) -> int:
    """Run the cases; 1 if any fails."""
    said = _parsed(arguments)
    if said.worker is not None:
        return _work(said)
    if said.replay:
        return _replay(said.replay)
    print(f"seed {said.seed}, {said.cases:,} cases", flush=True)  # noqa: T201
    began, found = time.monotonic(), _Found()
    _run(said, found)
    for sort, count in found.sorts.most_common():
        print(f"{count:>6} x {sort}\n         {found.examples[sort]}")  # noqa: T201
    minutes = (time.monotonic() - began) / 60
    print(f"{sum(found.sorts.values())} of {found.done:,} cases fail, seed {said.seed}, {minutes:.1f} min")  # noqa: T201
    return int(bool(found.sorts))


def _parsed(arguments: Sequence[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m tests.fuzz", description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--cases", type=int, default=3000)
    parser.add_argument("--seed", type=int, default=random.SystemRandom().randrange(10**6))
    parser.add_argument("--processes", type=int, default=min(2, os.cpu_count() or 1))
    parser.add_argument("--family", choices=list(FAMILIES))
    parser.add_argument("--number", type=int)
    parser.add_argument("--replay", type=Path, nargs="*")
    parser.add_argument("--worker", type=int, help=argparse.SUPPRESS)
    return parser.parse_args(arguments)


@dataclass
class _Found:
    """How often each sort of failure was found, with an example; and how many cases were run."""

    sorts: Counter[str] = field(default_factory=Counter)
    examples: dict[str, str] = field(default_factory=dict)
    done: int = 0

    def add(self, sort: str, detail: str, case: Case | None, number: int) -> None:
        """Count a failure; the first of its sort is kept."""
        self.sorts[sort] += 1
        if sort in self.examples:
            return
        self.examples[sort] = f"case {number}: {' '.join(detail.split())[:300]}"
        if case:
            CORPUS.mkdir(exist_ok=True)
            name = f"{case.family.replace(' ', '-')}-{hashlib.sha256(sort.encode()).hexdigest()[:8]}.json"
            (CORPUS / name).write_text(f"{case.line()}\n", "utf-8")
            self.examples[sort] += f"\n         python -m tests.fuzz --replay tests/fuzz/corpus/{name}"


def _run(said: argparse.Namespace, found: _Found) -> None:
    """Share the cases among processes; one that crashes or hangs is replaced behind the case at which it was."""
    numbers = [said.number] if said.number is not None else range(said.cases)
    processes = min(said.processes, len(numbers))
    selector = selectors.DefaultSelector()
    for part in range(processes):
        _start(said, part, processes, selector)
    shown = time.monotonic()
    while selector.get_map():
        for key, _ in selector.select(timeout=5) or ():
            worker: _Worker = key.data
            line = worker.pipe.readline()
            worker.heard = time.monotonic()
            if not line:
                selector.unregister(worker.pipe)
                worker.process.wait()
                if worker.process.returncode and worker.at < 0:
                    sys.exit("a process ended before its first case")
                if worker.process.returncode:
                    found.add(f"crash {worker.process.returncode}", "the process ended", None, worker.at)
                    _start(said, worker.at + processes, processes, selector)
                continue
            _take(json.loads(line), worker, found)
        for key in list(selector.get_map().values()):
            if time.monotonic() - key.data.heard > SILENCE:
                key.data.process.kill()
        if time.monotonic() - shown > 20:
            shown = time.monotonic()
            print(f"{found.done:,} cases, {sum(found.sorts.values())} fail", flush=True)  # noqa: T201


@dataclass
class _Worker:
    process: subprocess.Popen[str]
    pipe: IO[str]
    at: int
    heard: float


def _start(said: argparse.Namespace, first: int, step: int, selector: selectors.BaseSelector) -> None:
    command = [sys.executable, "-m", "tests.fuzz", "--worker", str(first), "--processes", str(step)]
    command += ["--cases", str(said.cases), "--seed", str(said.seed)]
    command += ["--family", said.family] if said.family else []
    command += ["--number", str(said.number)] if said.number is not None else []
    own = os.environ | {"PYTHONHASHSEED": "0", "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=ROOT, env=own)
    assert process.stdout
    worker = _Worker(process=process, pipe=process.stdout, at=-1, heard=time.monotonic())
    selector.register(process.stdout, selectors.EVENT_READ, worker)


def _take(said: dict[str, object], worker: _Worker, found: _Found) -> None:
    worker.at = int(str(said["at"]))
    if "sort" in said:
        case = read_case(str(said["case"])) if said["case"] else None
        found.add(str(said["sort"]), str(said["detail"]), case, worker.at)
    else:
        found.done += 1


def _work(said: argparse.Namespace) -> int:
    """Run every `processes`-th case from `worker` on, and report on the pipe."""
    from tests.fuzz import seeds
    from tests.fuzz.judging import Failure, Judge
    from tests.fuzz.minimising import minimised

    seen: set[str] = set()
    with os.fdopen(os.dup(1), "w") as pipe, tempfile.TemporaryDirectory() as folder:
        seeds.prepare()
        judge = Judge(Path(folder))
        for number in _numbers(said):
            print(json.dumps({"at": number}), file=pipe, flush=True)
            try:
                case = case_of(said.seed, number, said.family)
                failure = judge.failure(case)
            except Exception:  # a mistake in the trial is a failure too, and has its place
                failure = Failure(
                    sort=f"the trial itself {traceback.format_exc().splitlines()[-1]}",
                    detail=traceback.format_exc()[-900:],
                )
                seen.add(failure.sort)
            if failure is None:
                continue
            sort, small = failure.sort, None
            if sort not in seen:
                seen.add(sort)
                waits = "wall time" in failure.detail
                small = (
                    case
                    if waits
                    else minimised(case, lambda one, sort=sort: getattr(judge.failure(one), "sort", None) == sort)
                )
            line = small.line() if small else ""
            print(
                json.dumps({"at": number, "sort": sort, "detail": failure.detail[:2000], "case": line}),
                file=pipe,
                flush=True,
            )
        os.chdir("/")
    return 0


def _numbers(said: argparse.Namespace) -> Iterator[int]:
    if said.number is not None:
        yield from [said.number][said.worker :]
    else:
        yield from range(said.worker, said.cases, said.processes)


def _replay(paths: Sequence[Path]) -> int:
    """Run kept cases; 1 if any fails."""
    from tests.fuzz.judging import Judge

    cases = {path: read_case(path.read_text("utf-8")) for path in paths}
    code = 0
    with os.fdopen(os.dup(1), "w") as pipe, tempfile.TemporaryDirectory() as folder:
        judge = Judge(Path(folder))
        for path, case in cases.items():
            if failure := judge.failure(case):
                print(f"{path.name}: {failure.sort}: {failure.detail}\n    {case.argv}", file=pipe)
                code = 1
        os.chdir("/")
    return code


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
