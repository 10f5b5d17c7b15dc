"""Cost of rsegen and of others: the same grids, in one run, each work in fresh children.

python -m benchmarks.speed            the record in benchmarks/results, in about ten minutes
python -m benchmarks.speed --quick    sizes up to 320 in under two minutes, printed and not kept
python -m benchmarks.speed --full     with a million blocks the slow ways too, and 4000 x 4000 with rsegen
python -m benchmarks.speed --starts   what starts take, of Python, help and a small world; the rest of the record stays
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

from benchmarks import measure
from benchmarks.figures import RESULTS, Faces, Results, Row, Run, loaded, saved
from benchmarks.machine import machine
from benchmarks.report import page
from benchmarks.ways import LARGEST, MATRICES, SIZES, WAYS, Command, Way, commands


@dataclass(frozen=True, kw_only=True, slots=True)
class Plan:
    """Measurements: sizes; how often at most, and for how many seconds; how many maps; the slow ways too or not."""

    text: str
    sizes: tuple[int, ...]
    runs: int = 5
    seconds: float = 60
    maps: int = 1000
    full: bool = False


PLANS = {
    "usual": Plan(text="usual", sizes=SIZES),
    "quick": Plan(text="quick", sizes=SIZES[:3], runs=3, seconds=5, maps=200),
    "full": Plan(text="full", sizes=(*SIZES, LARGEST), full=True),
}


@dataclass(kw_only=True, slots=True)
class Work:
    """A row in the making."""

    row: Row
    attempt: Callable[[], Run]
    runs: list[Run] = field(default_factory=list)
    missing: str = ""

    def once(self, plan: Plan) -> None:
        """One run more, unless it failed or took its time already."""
        spent = sum(run.wall for run in self.runs)
        if self.missing or (self.runs and spent + self.runs[-1].wall > plan.seconds):
            return
        try:
            self.runs.append(self.attempt())
        except measure.Failed as failure:
            self.missing = str(failure)
        print(f"{self.row.name} {self.row.size}: {self.missing or self.runs[-1]}", file=sys.stderr)

    def result(self) -> Row:
        """The row with its medians."""
        middle = measure.middle(self.runs) if self.runs else None
        return replace(self.row, runs=len(self.runs), middle=middle, missing=self.missing)


def measured(plan: Plan, isaaclab: str) -> Results:
    """Everything that the plan asks for; the short commands first, before gigabytes wait for the disk."""
    where, commanded = machine(), tuple(_rounds(_commandings(plan), plan))
    return Results(
        machine=where,
        plan=f"{plan.text}, K = {', '.join(map(str, plan.sizes))}",
        writers=tuple(row for size in plan.sizes for row in _rounds(_writings(plan, size, isaaclab), plan)),
        commands=commanded,
        faces=tuple(Faces(**each) for each in _counted(plan)),  # type: ignore[arg-type]  # as printed
    )


def starts_anew(plan: Plan, record: Results) -> Results:
    """A record whose starts (10 x 10 blocks, one map) are measured anew, on a machine like that of the record."""
    where = machine()
    if _without_load(where) != _without_load(record.machine):
        sys.exit(f"the record is of {record.machine}, and this is {where}: measure all of it")
    works = [work for work in _commandings(replace(plan, sizes=SIZES[:1])) if work.row.count == 1]
    anew = {(row.name, row.size): row for row in _rounds(works, plan)}
    rows = (row if row.count > 1 else anew.get((row.name, row.size), row) for row in record.commands)
    text = f"{record.plan.partition('; ')[0]}; starts measured later, with {_load(where)}"
    return replace(record, plan=text, commands=tuple(rows))


def _load(where: str) -> str:
    return next(part for part in where.split(", ") if "busy" in part).partition(";")[0]


def _without_load(where: str) -> str:
    return where.replace(_load(where), "")


def _rounds(works: list[Work], plan: Plan) -> list[Row]:
    """All once, then all again, so that what else the machine does hits all alike."""
    for _ in range(plan.runs):
        for work in works:
            work.once(plan)
    return [work.result() for work in works]


def _writings(plan: Plan, size: int, isaaclab: str) -> list[Work]:
    bearable = [way for way in WAYS if size <= (way.largest_full if plan.full else way.largest)]
    return [_writing(way, size, isaaclab if way.name == "isaaclab" else sys.executable) for way in bearable]


def _writing(way: Way, size: int, python: str) -> Work:
    row = Row(name=way.name, title=f"{way.title} ({way.faces})", size=size)
    return Work(row=row, attempt=partial(measure.written, way, size, python))


def _commandings(plan: Plan) -> list[Work]:
    wanted = [command for command in commands(plan.maps) if command.size <= max(plan.sizes)]
    return [_work(command, partial(measure.commanded, command)) for command in wanted] + [
        _work(MATRICES, partial(measure.built, MATRICES.count))
    ]


def _work(command: Command, attempt: Callable[[], Run]) -> Work:
    row = Row(name=command.name, title=command.title, size=command.size, count=command.count)
    return Work(row=row, attempt=attempt)


def _counted(plan: Plan) -> list[dict[str, object]]:
    return measure.counted(plan.runs + 1, [size for size in plan.sizes if size <= 320])


def main(arguments: list[str]) -> int:
    """Measure, print, and keep what is worth keeping."""
    given = _given(arguments)
    plan = PLANS["full" if given.full else "quick" if given.quick else "usual"]
    plan = replace(plan, sizes=tuple(given.sizes or plan.sizes), runs=given.runs or plan.runs)
    record = RESULTS / "speed.json"
    results = starts_anew(plan, loaded(record)) if given.starts else measured(plan, given.isaaclab)
    folder = given.output or (None if given.quick else RESULTS)
    if folder:
        _keep(results, folder)
    print(page(results))
    return 0


def _keep(results: Results, folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in (("speed.json", saved(results)), ("speed.md", page(results))):
        (folder / name).write_text(text, "utf-8", newline="\n")


def _given(arguments: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.speed")
    length = parser.add_mutually_exclusive_group()
    length.add_argument("--quick", action="store_true", help="under two minutes")
    length.add_argument("--full", action="store_true", help="the slow ways and the largest grid too")
    length.add_argument("--starts", action="store_true", help="starts of commands alone; the rest of the record stays")
    parser.add_argument("--sizes", type=int, nargs="+", metavar="K", help="blocks a side, in place of the plan's")
    parser.add_argument("--runs", type=int, metavar="N", help="of each work at most, in place of the plan's")
    parser.add_argument("--output", type=Path, metavar="DIR", help="benchmarks/results, or none where --quick")
    parser.add_argument("--isaaclab", default=sys.executable, metavar="PYTHON", help="one that has IsaacLab installed")
    return parser.parse_args(arguments)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
