"""The outcomes of an experiment as a Markdown page, CSV and a plot."""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields
from math import pi, sqrt
from statistics import median, stdev

from rsegen.simulation.experiment.plan import PACES, Cell, ExperimentPlan, TableRow
from rsegen.simulation.experiment.published import COMPUTER, FIGURES
from rsegen.simulation.experiment.results import Results
from rsegen.simulation.experiment.trial import Outcome
from rsegen.simulation.simulators import SIMULATORS

_PACES = {
    "real": "in real time",
    "free": "at full speed",
    "beside": "at full speed in turns with an empty world (± the standard error)",
}


def report_page(plan: ExperimentPlan, results: Results, machine: Mapping[str, str]) -> str:
    """The Markdown page: the machine, and a table per row of the plan with the paper's figures."""
    return (
        "\n".join(
            [*_head(plan, machine), *(line for numbers in plan.tables for line in _table(plan, numbers, results))]
        )
        + "\n"
    )


def trials_csv(plan: ExperimentPlan, results: Results) -> str:
    """The text of trials.csv, a line per trial."""
    names = [field.name for field in fields(Outcome)]
    lines = [",".join(["simulator", "robot", "robots", "size", "pace", *names])]
    for cell, outcomes in results.items():
        row = plan.rows[cell.row]
        start = [row.simulator or "", row.robot, str(row.robots), str(cell.size), cell.pace]
        lines += [",".join([*start, *(_plain(getattr(one, name)) for name in names)]) for one in outcomes]
    return "\n".join(lines) + "\n"


def plot(plan: ExperimentPlan, results: Results) -> bytes:
    """A PNG of speed and memory over the side of the map, a curve per row."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 4.5), dpi=100, layout="constrained")
    for axes, (name, title) in zip(
        figure.subplots(1, 2),
        (("speed", "simulated seconds for a second of CPU"), ("memory", "memory of the simulator [MB]")),
        strict=True,
    ):
        for number, row in enumerate(plan.rows):
            points = [(size, median_of(_of(results, number, size, _pace(plan)), name)) for size in row.sizes]
            known = [(size, value) for size, value in points if value is not None]
            axes.plot(*zip(*known, strict=True), "o-", label=_label(plan, row)) if known else None
        axes.set(xlabel="side of the map [blocks], 0: empty", title=title)
        axes.set_ylim(bottom=0)
        axes.grid(visible=True, alpha=0.3)
    figure.axes[0].legend()
    stream = io.BytesIO()
    figure.savefig(stream, format="png")
    return stream.getvalue()


def median_of(outcomes: Sequence[Outcome], name: str) -> float | None:
    """The median of a figure of outcomes; None if none has it."""
    found = [value for value in (getattr(one, name) for one in outcomes) if value is not None]
    return median(found) if found else None


def _head(plan: ExperimentPlan, machine: Mapping[str, str]) -> Iterator[str]:
    yield f"# Experiment: {plan.name}\n"
    yield f"Made by `rsegen experiment {plan.name}`: {_trials(plan)} in mixed order;"
    paces = " and ".join(_PACES[pace] for pace in plan.paces)
    yield f"robots wander for {plan.seconds:g} seconds by the clock on the wall, {paces}."
    yield "No window, so no GPU load and no frames a second.\n"
    yield "| machine | |\n|---|---|"
    yield from (f"| {name} | {value} |" for name, value in machine.items())
    yield f"\nThe paper's computer: {COMPUTER}; with a window.\n"


def _trials(plan: ExperimentPlan) -> str:
    return "one trial of each cell" if plan.repeats == 1 else f"medians of {plan.repeats} trials of each cell"


def _label(plan: ExperimentPlan, row: TableRow) -> str:
    """The label of a row, with its simulator if the plan has several."""
    several = len({each.simulator for each in plan.rows}) > 1
    return row.label + (f", {_title(row)}" if several else "")


def _title(row: TableRow) -> str:
    return SIMULATORS[row.simulator].title if row.simulator else ""


def _table(plan: ExperimentPlan, numbers: Sequence[int], results: Results) -> Iterator[str]:
    """The table of rows that differ by the simulator only; the paper's figures, which are of Gazebo Classic, beside."""
    rows = [plan.rows[number] for number in numbers]
    several = len(numbers) > 1
    first = rows[0]
    yield f"## {first.label}{'' if several or not _title(first) else f', in {_title(first)}'}\n"
    printed = any(_published(row) for row in rows)
    yield (
        ("| simulator " if several else "")
        + "| blocks | RTF min, mean, max | CPU | memory | load | simulated s a CPU s | of the empty world's |"
        + (" paper: RTF | CPU | memory |" if printed else "")
    )
    yield "|---" * several + "|---|---|---|---|---|---|---|" + ("---|---|---|" if printed else "")
    for size in dict.fromkeys(size for row in rows for size in row.sizes):
        for number, row in zip(numbers, rows, strict=True):
            found = {pace: _of(results, number, size, pace) for pace in PACES}
            if any(found.values()):
                paper = _published(row).get(size, ("", "", "")) if printed else ()
                cells = _cells(size, found, _empty(plan, results, row))
                yield "| " + " | ".join([*([_title(row)] if several else []), *cells, *paper]) + " |"
    yield ""


def _published(row: TableRow) -> Mapping[int, Sequence[str]]:
    return {} if row.recipe or row.simulator == "sim" else FIGURES.get(row.robot, {})


def _cells(size: int, found: Mapping[str, Sequence[Outcome]], empty: Sequence[Outcome]) -> list[str]:
    real, free = found["real"], [*found["free"], *found["beside"]]
    cpu = median_of(real, "cpu")
    return [
        f"{size} x {size}" if size else "empty",
        ", ".join(_plain(median_of(real, name), 2) for name in ("rtf_min", "rtf", "rtf_max")) if real else "-",
        f"{cpu * 100:.0f} % of a core" if cpu is not None else "-",
        f"{_plain(median_of([*real, *free], 'memory'), 0)} MB",
        f"{_plain(median_of([*real, *free], 'load'), 1)} s",
        _plain(median_of(free, "speed"), 1),
        _share(found["beside"]) or _quotient(median_of(found["free"], "speed"), median_of(empty, "speed")),
    ]


def _share(beside: Sequence[Outcome]) -> str:
    """Of the speed of the empty world in turns with which it was simulated, and how far that is sure."""
    shares = [outcome.share for outcome in beside if outcome.share is not None]
    if len(shares) < 2:
        return "".join(f"{share:.2f}" for share in shares)
    return f"{median(shares):.2f} ± {sqrt(pi / 2 / len(shares)) * stdev(shares):.2f}"


def _quotient(speed: float | None, usual: float | None) -> str:
    return f"{speed / usual:.2f}" if speed and usual else "-"


def _empty(plan: ExperimentPlan, results: Results, row: TableRow) -> Sequence[Outcome]:
    """The same robots in an empty world at full speed, in whichever row they were."""
    alike = (
        number
        for number, each in enumerate(plan.rows)
        if (each.robot, each.robots, each.simulator) == (row.robot, row.robots, row.simulator)
    )
    return next((found for number in alike if (found := _of(results, number, 0, "free"))), ())


def _of(results: Results, row: int, size: int, pace: str) -> Sequence[Outcome]:
    return results.get(Cell(row=row, size=size, pace=pace), [])


def _pace(plan: ExperimentPlan) -> str:
    return "free" if "free" in plan.paces else plan.paces[0]


def _plain(value: float | None, digits: int = 4) -> str:
    if value is None:
        return ""
    return f"{value:.{digits}f}".rstrip("0").rstrip(".") if digits > 2 else f"{value:.{digits}f}"
