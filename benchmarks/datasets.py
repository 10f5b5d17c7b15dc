"""Cost of data sets: `python -m benchmarks.datasets` makes four of them, each ten times larger than the one before.

Whole commands of maps of 10 x 10 random blocks of six levels, in children, with one worker so that CPU seconds are of
one core; then a million with two. Beside them complete worlds of the same maps, up to ten thousand. Their figures are
printed, and kept in benchmarks/results; docs/datasets.md has them.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

from benchmarks import measure
from benchmarks.figures import RESULTS, Results, Row, Run, saved
from benchmarks.machine import machine
from benchmarks.report import verdicts
from benchmarks.speed import Plan, Work
from benchmarks.targets import Reading, Target
from benchmarks.ways import FOLDER, Command, worlds

SIZE = 10
COUNTS = (1_000, 10_000, 100_000, 1_000_000)
WORLDS = 10_000
"""Complete worlds that are made at the most: each is eight files."""

RUNS = 3
FILE = RESULTS / "datasets.json"


def command(count: int, workers: int, metrics: str) -> Command:
    """The command that makes a data set of so many maps."""
    wanted = f"--chunk-size {SIZE} --boundary none --maps {count} --seed 1 --workers {workers} --metrics {metrics}"
    arguments = ("dataset", *wanted.split(), "--obstacle", "random levels=6", "-o", FOLDER)
    return Command(
        name=f"{metrics}-{workers}",
        title=f"`rsegen dataset --workers {workers} --metrics {metrics}`",
        arguments=(sys.executable, "-m", "rsegen", *arguments),
        size=SIZE,
        count=count,
    )


def complete(count: int) -> Command:
    """The command that makes so many complete worlds."""
    found = worlds("single", SIZE, count)
    arguments = (*found.arguments, "--workers", "1")
    return replace(found, name="worlds-1", title="`rsegen generate --workers 1`", arguments=arguments)


def commands(counts: tuple[int, ...]) -> Iterator[Command]:
    """Complete worlds, and data sets with and without metrics, by one worker; and the largest data set by two."""
    for count in counts:
        if count <= WORLDS:
            yield complete(count)
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


def _figure(name: str, count: int, reading: Callable[[Run], float]) -> Reading:
    def figure(results: Results) -> float | None:
        rows = (row for row in results.commands if (row.name, row.count) == (name, count))
        return next((reading(row.middle) for row in rows if row.middle), None)

    return figure


def _grown(results: Results) -> float | None:
    """CPU of a million maps over that of as many hundred thousands, without what a start takes."""
    ten, hundred, thousand = (_figure("npy-1", count, lambda run: run.cpu)(results) for count in COUNTS[1:])
    if ten is None or hundred is None or thousand is None:
        return None
    return (thousand - hundred) / (hundred - ten) / 10


_MILLION = COUNTS[-1]
TARGETS = (
    Target(
        text="complete worlds per second and core",
        figure=_figure("worlds-1", WORLDS, lambda run: WORLDS / run.cpu),
        limit=300,
        unit="/s",
        at_most=False,
    ),
    Target(
        text="maps per second and core",
        figure=_figure("none-1", _MILLION, lambda run: _MILLION / run.cpu),
        limit=20_000,
        unit="/s",
        at_most=False,
    ),
    Target(
        text="a million maps with metrics on two cores, wall time",
        figure=_figure("npy-2", _MILLION, lambda run: run.wall),
        limit=120,
        unit="s",
    ),
    Target(
        text="three times the peak memory of a process",
        figure=_figure("npy-2", _MILLION, lambda run: 3 * run.rss / 1e6),
        limit=1000,
        unit="MB",
    ),
    Target(text="CPU per map, from 100,000 on / up to there", figure=_grown, limit=1.25, unit="x"),
)


def table(results: Results) -> Iterator[str]:
    """The figures as lines of Markdown."""
    yield from verdicts(TARGETS, results)
    yield ""
    yield "| 10 x 10 blocks | maps | CPU s | CPU us per additional map | wall s | peak MB of a process | bytes |"
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
    results = measured(counts, Plan(text="datasets", sizes=(SIZE,), runs=RUNS, seconds=100))
    print("\n".join(table(results)))
    if not arguments:
        FILE.write_text(saved(results), "utf-8", newline="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
