"""Runs cases in this process, and says in a line of JSON each that one begins, and how it fails."""

from __future__ import annotations

import json
import os
import tempfile
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TextIO

from tests.fuzz import seeds
from tests.fuzz.case import Case, read_case
from tests.fuzz.families import case_of
from tests.fuzz.judging import Failure, Judge
from tests.fuzz.minimising import minimised


def work(first: int, step: int, cases: int, seed: int, family: str | None) -> int:
    """Run every `step`-th case of a seed, from `first` on."""
    seen: set[str] = set()
    seeds.prepare()
    with _judge() as (judge, pipe):
        for number in range(first, cases, step):
            _say(pipe, at=number)
            case = case_of(seed, number, family)
            failure = _failure(judge, case)
            if failure:
                line = "" if failure.sort in seen else _small(judge, case, failure).line()
                seen.add(failure.sort)
                _say(pipe, at=number, sort=failure.sort, detail=failure.detail[:2000], case=line)
    return 0


def replay(paths: Sequence[Path]) -> int:
    """Run the cases in files; 1 if any fails."""
    cases = {path: read_case(path.read_text("utf-8")) for path in paths}
    code = 0
    with _judge() as (judge, pipe):
        for path, case in cases.items():
            if failure := judge.failure(case):
                print(f"{path.name}: {failure.sort}: {failure.detail}\n    {case.argv}", file=pipe)
                code = 1
    return code


@contextmanager
def _judge() -> Iterator[tuple[Judge, TextIO]]:
    """A judge in a folder of its own, and this process's output, which the judge takes away."""
    home = Path.cwd()
    with os.fdopen(os.dup(1), "w") as pipe, tempfile.TemporaryDirectory() as folder:
        try:
            yield Judge(Path(folder)), pipe
        finally:
            os.chdir(home)


def _say(pipe: TextIO, **said: object) -> None:
    print(json.dumps(said), file=pipe, flush=True)


def _failure(judge: Judge, case: Case) -> Failure | None:
    try:
        return judge.failure(case)
    except Exception:  # a mistake in the trial itself must not end it
        text = traceback.format_exc()
        return Failure(sort=f"the trial itself: {text.splitlines()[-1]}", detail=text[-1500:])


def _small(judge: Judge, case: Case, failure: Failure) -> Case:
    """A small case that fails alike; the same if each trial of one would take long."""
    if failure.sort.startswith(("too long", "the trial")):
        return case

    def fails(smaller: Case) -> bool:
        found = _failure(judge, smaller)
        return found is not None and found.sort == failure.sort

    return minimised(case, fails)
