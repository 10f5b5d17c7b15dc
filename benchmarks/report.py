"""The figures as Markdown: the page of results, and the small table of what was measured."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from benchmarks.figures import Results, Row, Run
from benchmarks.targets import TARGETS, Target

MARKS = ("<!-- figures: made by docs.generate from benchmarks/results -->", "<!-- end of figures -->")
"""Between these lines of a page its table stands."""

_VERDICTS = {True: "met", False: "**missed**", None: "not measured"}

_HOW = """\
`make bench` measures; `make docs` puts the figures here. Each work runs in its own process, all children of one size
in turn, and a figure is the median of its runs. CPU is user and system time; compare that and the ratios, for wall time
depends on what else the machine does. A grid to a file: seconds without Python's start and imports, from the levels in
memory to the closed file, each library with the one thread that it needs; peak memory is that of the whole child,
libraries included. Files are written in memory (/dev/shm) where that can be, for what a disk takes varies more than
anything measured here. Blocks are 0.1 m wide and 1 to 5 units of 0.1 m high, at random, the same for every way, though
IsaacLab draws heights of its own. The surface that rsegen writes is open at the ground. A MB is a million bytes."""


def page(results: Results) -> str:
    """All figures."""
    return "\n".join(_page(results)) + "\n"


def with_table(text: str, results: Results, below: Iterable[str] = ()) -> str:
    """A text, with the table between its marks, and lines below it, made anew; the rest as it was."""
    return filled(text, [*_small(results), *below])


def filled(text: str, lines: Iterable[str], marks: tuple[str, str] = MARKS) -> str:
    """A text, with the lines between its marks put in the place of those that are there."""
    begin, end = marks
    before, _, rest = text.partition(begin)
    _, found, after = rest.partition(end)
    if not found:
        raise ValueError(f"the text has no line {begin} with {end} after it")
    return before + "\n".join((begin, *lines, end)) + after


def _page(results: Results) -> Iterator[str]:
    yield f"# Speed and size\n\n{_HOW}\n\nMeasured on: {results.machine}. Plan: {results.plan}.\n\n## Targets\n"
    yield from verdicts(TARGETS, results)
    yield "\n## A grid to a file"
    for size in dict.fromkeys(row.size for row in results.writers):
        yield f"\n### {size:,} x {size:,} blocks\n"
        yield _head("way", "CPU s", "x the loop's CPU", "wall s", "peak MB", "bytes", "faces", "runs")
        yield from (_writer(row, results) for row in results.rows(size))
    yield "\n## Whole commands\n\nFrom start to exit, imports included; random blocks of 0 to 5 units without frames.\n"
    yield _head("command", "blocks", "maps", "wall s", "CPU s", "peak MB", "bytes", "runs")
    yield from (_command(row) for row in results.commands)
    yield "\n## Many maps\n"
    yield _head("work", "maps per second", "maps per second of CPU")
    yield from (_rates(row) for row in results.commands if row.count > 1)
    yield from _faces(results)


def verdicts(targets: Iterable[Target], results: Results) -> Iterator[str]:
    """A table of targets: what was measured, how often the target goes into that, and whether it is enough."""
    yield _head("figure", "measured", "target", "measured / target", "")
    for target in targets:
        found, ratio = target.figure(results), target.ratio(results)
        bound = f"{'at most' if target.at_most else 'at least'} {short(target.limit)} {target.unit}"
        measured = "" if found is None else f"{short(found)} {target.unit}"
        times = "" if ratio is None else short(ratio)
        yield f"| {target.text} | {measured} | {bound} | {times} | {_VERDICTS[target.met(results)]} |"


def _writer(row: Row, results: Results) -> str:
    run = row.middle
    if run is None:
        return f"| {row.title} | {row.missing} | | | | | | |"
    cells = (short(run.cpu), _ratio(run, results.middle("loop", row.size)), short(run.wall), _mb(run.rss))
    return f"| {row.title} | {' | '.join(cells)} | {run.bytes:,} | {run.faces:,} | {row.runs} |"


def _ratio(run: Run, loop: Run | None) -> str:
    return short(run.cpu / loop.cpu) if loop else ""


def _command(row: Row) -> str:
    run = row.middle
    what = f"| {row.title} | {f'{row.size} x {row.size}' if row.size else ''} | {row.count if row.size else ''} |"
    if run is None:
        return f"{what} {row.missing} | | | | |"
    size = f"{run.bytes:,}" if run.bytes else ""
    return f"{what} {short(run.wall)} | {short(run.cpu)} | {_mb(run.rss)} | {size} | {row.runs} |"


def _rates(row: Row) -> str:
    work = f"| {row.title}, {row.size} x {row.size} |"
    run = row.middle
    if run is None:
        return f"{work} {row.missing} | |"
    return f"{work} {row.count / run.wall:,.0f} | {row.count / run.cpu:,.0f} |"


def _faces(results: Results) -> Iterator[str]:
    yield "\n## Faces\n"
    yield "Naive: six per block. Exposed: one per top and one per height difference. Merged: what rsegen writes.\n"
    yield _head("grid", "blocks", "naive", "exposed", "merged", "merged / naive", "merged / exposed", "seeds")
    for each in results.faces:
        counts = f"{each.naive:,.0f} | {each.exposed:,.0f} | {each.merged:,.0f}"
        shares = f"{each.merged / each.naive:.3f} | {each.merged / each.exposed:.3f}"
        yield f"| {each.grid} | {each.size} x {each.size} | {counts} | {shares} | {each.seeds} |"


def _small(results: Results) -> Iterator[str]:
    """The largest grid that both rsegen and the loop wrote."""
    both = [row.size for row in results.writers if row.name == "merged" and results.middle("loop", row.size)]
    size = max(both, default=0)
    yield _head(f"{size:,} x {size:,} random blocks to a file", "CPU s", "peak MB", "file, MB", "faces")
    for row in results.rows(size):
        if row.middle:
            run = row.middle
            yield f"| {row.title} | {short(run.cpu)} | {_mb(run.rss)} | {short(run.bytes / 1e6)} | {run.faces:,} |"


def _head(*names: str) -> str:
    return f"| {' | '.join(names)} |\n|{'---|' * len(names)}"


def short(value: float) -> str:
    """A number with three digits that count."""
    return f"{value:,.0f}" if value >= 100 else f"{value:.3g}"


def _mb(size: float) -> str:
    return f"{size / 1e6:,.0f}"
