"""What a data set costs: `python -m benchmarks.datasets` makes four of them, each ten times larger than the one before.

Whole commands of maps of 10 x 10 random blocks of six levels, in children, with one worker so that CPU seconds are of
one core; then a million with two. Their figures are printed, and kept in benchmarks/results; docs/datasets.md has them.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from functools import partial

from benchmarks import measure
from benchmarks.figures import RESULTS, Results, Row, Run, saved
from benchmarks.machine import machine
from benchmarks.speed import Plan, Work
from benchmarks.ways import FOLDER, Command

SIZE = 10
COUNTS = (1_000, 10_000, 100_000, 1_000_000)
FILE = RESULTS / "datasets.json"


def command(count: int, workers: int, metrics: str) -> Command:
    """The command that makes a data set of so many maps."""
    wanted = f"--chunk-size {SIZE} --boundary none --maps {count} --seed 1 --workers {workers} --metrics {metrics}"
    arguments = ("dataset", *wanted.split(), "--obstacle", "random max_height=6", "-o", FOLDER)
    return Command(
        name=f"{metrics}-{workers}",
        title=f"`rsegen dataset --workers {workers} --metrics {metrics}`",
        arguments=(sys.executable, "-m", "rsegen", *arguments),
        size=SIZE,
        count=count,
    )


def commands(counts: tuple[int, ...]) -> Iterator[Command]:
    """With and without metrics, by one worker; and the largest by two."""
    for count in counts:
        yield command(count, 1, "none")
        yield command(count, 1, "npy")
    yield command(max(counts), 2, "npy")


def measured(counts: tuple[int, ...], plan: Plan) -> Results:
    """All of them, once, then again."""
    where = machine()
    works = [
        Work(
            row=Row(name=each.name, title=each.title, size=each.size, count=each.count),
            attempt=partial(measure.commanded, each),
        )
        for each in commands(counts)
    ]
    for _ in range(plan.runs):
        for work in works:
            work.once(plan)
    return Results(machine=where, plan=plan.text, commands=tuple(work.result() for work in works))


def table(results: Results) -> Iterator[str]:
    """The figures as lines of Markdown."""
    yield "| 10 x 10 blocks | maps | CPU s | CPU us for each map more | wall s | peak MB of a process | bytes |"
    yield "|---|---|---|---|---|---|---|"
    before: dict[str, tuple[int, float]] = {}
    for row in results.commands:
        if row.middle:
            yield f"| {row.title} | {row.count:,} | {_figures(row.middle, _more(row, row.middle, before))} |"
            before[row.name] = row.count, row.middle.cpu
    yield f"\nMeasured on: {results.machine}. Python's start and imports are counted in CPU s."


def _more(row: Row, run: Run, before: dict[str, tuple[int, float]]) -> str:
    """Microseconds of CPU for each map that this row has more than the one before: without what any start takes."""
    if row.name not in before:
        return ""
    count, cpu = before[row.name]
    return f"{(run.cpu - cpu) / (row.count - count) * 1e6:.0f}"


def _figures(run: Run, more: str) -> str:
    return f"{run.cpu:.3g} | {more} | {run.wall:.3g} | {run.rss / 1e6:,.0f} | {run.bytes:,}"


def main(arguments: list[str]) -> int:
    """Measure and print; without COUNT ..., keep it too."""
    counts = tuple(map(int, arguments)) or COUNTS
    results = measured(counts, Plan(text="datasets", sizes=(SIZE,), runs=3, seconds=300))
    print("\n".join(table(results)))
    if not arguments:
        FILE.write_text(saved(results), "utf-8", newline="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
