"""The outcomes of an experiment as a Markdown page, CSV and a picture, next to the figures that the paper published.

A cell of the table has several trials. Costs are medians, which a noisy hour moves little; real-time factors are the
least, the mean and the most of all; what robots did are means, as it is random. The error of a share is the standard
error of the median of normally distributed values, sqrt(pi / 2 / n) times their standard deviation.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import fields
from math import pi, sqrt
from pathlib import Path
from statistics import fmean, median, stdev
from typing import TYPE_CHECKING, NamedTuple

from rsegen.exporters.pictures.preview import encoded
from rsegen.field.metrics.roughness import steps
from rsegen.recipe.building import build
from rsegen.robots import ROBOTS
from rsegen.simulation.experiment.plan import IN_REAL_TIME, PACES, Cell, ExperimentPlan, TableRow
from rsegen.simulation.experiment.results import Results
from rsegen.simulation.experiment.trial import SOURCES, STARVED, Outcome
from rsegen.simulation.simulators import SIMULATORS

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class PublishedFigures(NamedTuple):
    """A row of the paper's table 2, as printed."""

    rtf: str
    cpu: str
    memory: str

    @property
    def rtf_limits(self) -> tuple[float, float]:
        """The least and the most real-time factor."""
        least, _, most = self.rtf.partition("-")
        return float(least), float(most)


class PublishedRow(NamedTuple):
    """The maps and robots of a row of the paper."""

    robot: str
    robots: int
    unit_cm: float
    levels: int


# The paper's table 2, and the computer that it was made on, as printed.
COMPUTER = "Ryzen 7 2700X, GeForce 1660, 16 GB"

_CRAWLER = {
    0: PublishedFigures("0.27-0.30", "26 %", "7.6 GB"),
    10: PublishedFigures("0.26-0.29", "26 %", "7.6 GB"),
    20: PublishedFigures("0.25-0.28", "26 %", "7.6 GB"),
    40: PublishedFigures("0.25-0.28", "26 %", "7.7 GB"),
    60: PublishedFigures("0.25-0.28", "26 %", "7.7 GB"),
    80: PublishedFigures("0.24-0.28", "26 %", "7.7 GB"),
}
_BURGERS = {
    0: PublishedFigures("0.98-1", "8 %", "0.8 GB"),
    10: PublishedFigures("0.97-1", "8 %", "0.8 GB"),
    20: PublishedFigures("0.97-1", "8 %", "0.8 GB"),
    40: PublishedFigures("0.96-1", "8 %", "0.8 GB"),
    60: PublishedFigures("0.95-1", "8 %", "0.8 GB"),
    80: PublishedFigures("0.92-1", "8 %", "0.8 GB"),
}

FIGURES: Mapping[PublishedRow, Mapping[int, PublishedFigures]] = {
    PublishedRow("crawler", 1, 10, 5): {size: _CRAWLER[size] for size in (0, 10, 20)},
    PublishedRow("crawler", 1, 10, 10): {size: _CRAWLER[size] for size in (0, 40, 60, 80)},
    PublishedRow("burger", 3, 1, 5): _BURGERS,
}
"""Figures by robots and maps, and by the side of the map in blocks. The tracked robot had an arm, five cameras
and a lidar."""


def published_figures(row: TableRow) -> Mapping[int, PublishedFigures]:
    """Return the paper's figures for the robots and maps of a row, by size; it used Classic and random maps."""
    if row.recipe or row.simulator == "sim":
        return {}
    return FIGURES.get(PublishedRow(row.robot, row.robots, row.unit_cm, row.levels), {})


RESTING = 0.5
"""Share of the time, in the mean over robots and trials, that robots are stuck in a cell beyond which they rested."""


def outcomes_of(results: Results, row: int, size: int, pace: str) -> Sequence[Outcome]:
    """Return the outcomes of a cell; none if it was not tried yet."""
    return results.get(Cell(row=row, size=size, pace=pace), [])


def known(outcomes: Iterable[Outcome], name: str) -> list[float]:
    """Return a figure of those outcomes that have it."""
    return [value for value in (getattr(outcome, name) for outcome in outcomes) if value is not None]


def median_of(outcomes: Iterable[Outcome], name: str) -> float | None:
    """Return the median of a figure of outcomes; None if none has it."""
    values = known(outcomes, name)
    return median(values) if values else None


def mean_of(outcomes: Iterable[Outcome], name: str) -> float | None:
    """Return the mean of a figure of outcomes; None if none has it."""
    values = known(outcomes, name)
    return fmean(values) if values else None


def rtf_limits(outcomes: Sequence[Outcome]) -> tuple[float, float, float] | None:
    """Return the least, the mean and the most real-time factor over all trials; None without any."""
    least, mean, most = (known(outcomes, name) for name in ("rtf_min", "rtf", "rtf_max"))
    return (min(least), fmean(mean), max(most)) if least and mean and most else None


def standard_error(values: Sequence[float]) -> float:
    """Return the standard error of the median of two or more values, if they are normally distributed."""
    return sqrt(pi / 2 / len(values)) * stdev(values)


def rested(outcomes: Sequence[Outcome]) -> bool:
    """Return whether the robots rested for most of the time."""
    return (mean_of(outcomes, "stuck") or 0.0) > RESTING


MARK, STARVED_MARK = "†", "‡"
"""Marks of rows whose robots rested, and of rows with trials whose server was starved."""

_TITLES = {
    "real": "in real time",
    "free": "at full speed",
    "beside": "at full speed, alternating with an empty world (± the standard error)",
    "camera": "in real time with a camera",
    "window": "in real time with the simulator's window",
}
_LINES = {"": ("real", "free", "beside"), "with a camera": ("camera",), "with the window": ("window",)}
"""The paces whose figures are in one line of a table, by what its first cell says."""

_COLUMNS = ("blocks", "RTF min-max (mean)", "CPU: server", "CPU: machine", "memory", "load")
_RENDERING = ("frames per s", "GPU")
_AT_FULL_SPEED = ("simulated s per CPU s", "of the empty world's")
_ROBOTS = ("driven", "stuck", "tipped", "covered")
_INCIDENTS = ("off the map", "impossible", "attempts")
_PAPER = ("paper: RTF", "CPU", "memory")

_RESTED = f"{MARK} The robots were stuck for more than half of the time, so these are the costs of robots at rest."
_STARVED = (
    f"{STARVED_MARK} In some of these trials other programs left the server less than {STARVED:g} of a processor, so "
    "these are the costs of a busy machine: "
)
_UNKNOWN = "It was not recorded what the robots did in these trials, so speeds are not compared with the empty world."


def report_page(plan: ExperimentPlan, results: Results, machine: Mapping[str, str], command: str) -> str:
    """Return the Markdown page: the machine, and a table per row of the plan with the paper's figures.

    command: the command line that made the results.
    """
    head = _head(plan, results, machine, command)
    tables = (line for numbers in plan.tables for line in _table(plan, numbers, results))
    return "\n".join([*head, *tables]) + "\n"


def trials_csv(plan: ExperimentPlan, results: Results) -> str:
    """Return the text of trials.csv, a line per trial."""
    names = [field.name for field in fields(Outcome)]
    text = io.StringIO()
    lines = csv.writer(text, lineterminator="\n")  # the name of a robot's file may have a comma
    lines.writerow(["simulator", "robot", "robots", "size", "pace", *names])
    for cell, outcomes in results.items():
        row = plan.rows[cell.row]
        start = [row.simulator or "", row.robot, row.robots, cell.size, cell.pace]
        lines.writerows([*start, *(_plain(getattr(outcome, name)) for name in names)] for outcome in outcomes)
    return text.getvalue()


def _head(plan: ExperimentPlan, results: Results, machine: Mapping[str, str], command: str) -> Iterator[str]:
    yield f"# Experiment: {plan.name}\n"
    if still := dict.fromkeys(_still(plan, results)):
        yield f"**Robots stood still**, stuck for more than half of the time, where {MARK} is: {'; '.join(still)}.\n"
    yield f"Made by `{command}`: {plan.repeats} {'trial' if plan.repeats == 1 else 'trials'} per cell, in mixed"
    paces = " and ".join(_TITLES[pace] for pace in plan.paces)
    yield f"order; robots drive randomly for {plan.seconds:g} seconds of wall time, {paces}."
    yield "RTF: the smallest, the largest and the mean value of all trials. Robots: means per robot over all trials, in"
    yield "the simulation time of one trial. Everything else: medians of the trials."
    if len(mixed := [pace for pace in plan.paces if pace in _LINES[""]]) > 1:
        yield f"If a cell has several figures, they are {' / '.join(_TITLES[pace] for pace in mixed)}."
    if _has_incidents(results):
        yield "Off the map, impossible: shares of the robots that left the map, and that did what no robot can, with"
        yield "which their other figures end. Attempts: servers that the trials took, as those that fail are replaced."
    if not set(plan.paces) & set(SOURCES):
        yield "No window and no camera, so no frames per second."
    yield "\n| machine | |\n|---|---|"
    yield from (f"| {name} | {value} |" for name, value in machine.items())
    yield f"\nThe paper's computer: {COMPUTER}; with a window. Its RTF: smallest and largest value of three runs.\n"


def _still(plan: ExperimentPlan, results: Results) -> Iterator[str]:
    """Yield the robots and maps of rows in which robots rested, with the reason, if that is known."""
    for index, row in enumerate(plan.rows):
        sizes = [size for size in row.sizes if _rested_at(plan, results, index, size)]
        if sizes:
            yield _why_still(plan, results, row, [size for size in sizes if size])


def _rested_at(plan: ExperimentPlan, results: Results, index: int, size: int) -> bool:
    """Return whether the robots of a row rested at a size, at any pace."""
    return any(rested(outcomes_of(results, index, size, pace)) for pace in plan.paces)


def _why_still(plan: ExperimentPlan, results: Results, row: TableRow, maps: Sequence[int]) -> str:
    """Return why the robots of a row rested on maps of these sizes, or in the empty world if there is none."""
    name = f"{row.robots} {Path(row.robot).name}"
    if any(_rested_at(plan, results, alike, 0) for alike in _alike(plan, row)):
        where = f" in {_title(row)}" if _title(row) else ""
        return f"{name}{where}, without a map too, so maps are not the reason"
    what = f"{name}, unit {row.unit_cm:g} cm, {row.levels} levels"
    robot = ROBOTS.get(row.robot)
    above = steps(build(row.map_of(min(maps), plan.seed))).share_above(robot.climbs) if robot else None
    if not robot or not above:
        return f"{what}, for a reason that is not known"
    return f"{what}, as {above:.0%} of the steps are higher than the {100 * robot.climbs:g} cm that it climbs"


def _has_incidents(results: Results) -> bool:
    """Return whether it was recorded what happened to robots and servers, which earlier trials have not."""
    return any(known(outcomes, "attempts") for outcomes in results.values())


def row_label(plan: ExperimentPlan, row: TableRow) -> str:
    """Return the label of a row, with its simulator if the plan has several."""
    several = len({other.simulator for other in plan.rows}) > 1
    return row.label + (f", {_title(row)}" if several else "")


def _title(row: TableRow) -> str:
    return SIMULATORS[row.simulator].title if row.simulator else ""


def _table(plan: ExperimentPlan, numbers: Sequence[int], results: Results) -> Iterator[str]:
    """Yield the table of rows that differ by the simulator only, and its footnotes."""
    rows = [plan.rows[index] for index in numbers]
    several, first = len(numbers) > 1, rows[0]
    yield f"## {first.label}{'' if several or not _title(first) else f', in {_title(first)}'}\n"
    rendering = bool(set(SOURCES) & set(plan.paces)) or any(known(outcomes, "gpu") for outcomes in results.values())
    printed = any(published_figures(row) for row in rows)
    incidents = _INCIDENTS if _has_incidents(results) else ()
    columns = [*_COLUMNS, *(_RENDERING if rendering else ()), *_AT_FULL_SPEED, *_ROBOTS, *incidents]
    columns += _PAPER if printed else ()
    yield _line([*(["simulator"] if several else []), *columns])
    yield "|---" * (len(columns) + several) + "|"
    lines = list(_lines(plan, numbers, results, rendering=rendering, printed=printed))
    yield from (_line([*([title] if several else []), *cells]) for title, cells in lines)
    if any(MARK in cells[0] for _, cells in lines):
        yield f"\n{_RESTED}"
    tried = [outcomes for cell, outcomes in results.items() if cell.row in numbers]
    starved = [outcome for outcomes in tried for outcome in outcomes if outcome.starved]
    if starved:
        yield f"\n{_STARVED}{_of_the_starved(starved)}."
    if not all(known(outcomes, "driven") for outcomes in tried):
        yield f"\n{_UNKNOWN}"
    yield ""


def _lines(
    plan: ExperimentPlan, indices: Sequence[int], results: Results, *, rendering: bool, printed: bool
) -> Iterator[tuple[str, list[str]]]:
    """Yield the title of its simulator, and the cells, of each line of a table."""
    rows = {index: plan.rows[index] for index in indices}
    for size in dict.fromkeys(size for row in rows.values() for size in row.sizes):
        for index, row in rows.items():
            for what, paces in _LINES.items():
                by_pace = {pace: outcomes_of(results, index, size, pace) for pace in PACES if pace in paces}
                if any(by_pace.values()):
                    cells = [*_costs(by_pace), *(_rendered(by_pace) if rendering else ())]
                    cells += [*_full_speed(by_pace, _empty(plan, results, row)), *_robots(by_pace)]
                    cells += _incidents(by_pace) if _has_incidents(results) else []
                    paper = published_figures(row).get(size, ("", "", "")) if not what else ("", "", "")
                    label = ", ".join(filter(None, (_blocks(size), what)))
                    mark = f" {MARK}" if any(map(rested, by_pace.values())) else ""
                    every = [outcome for outcomes in by_pace.values() for outcome in outcomes]
                    mark += f" {STARVED_MARK}" if any(outcome.starved for outcome in every) else ""
                    yield _title(row), [label + mark, *cells, *(paper if printed else ())]


def _costs(by_pace: Mapping[str, Sequence[Outcome]]) -> list[str]:
    real = [outcome for pace in IN_REAL_TIME for outcome in by_pace.get(pace, ())]
    every = [outcome for outcomes in by_pace.values() for outcome in outcomes]
    rtf, cpu, machine = rtf_limits(real), median_of(real, "cpu"), median_of(real, "machine")
    return [
        f"{rtf[0]:.2f}-{rtf[2]:.2f} ({rtf[1]:.2f})" if rtf else "-",
        f"{cpu * 100:.0f} % of a core" if cpu is not None else "-",
        _percent(machine) or "-",
        f"{_plain(median_of(every, 'memory'), 0)} MB",
        f"{_plain(median_of(every, 'load'), 1)} s",
    ]


def _rendered(by_pace: Mapping[str, Sequence[Outcome]]) -> list[str]:
    """Frames per second and load of the GPU; empty where there are none."""
    every = [outcome for outcomes in by_pace.values() for outcome in outcomes]
    return [_plain(median_of(every, "fps"), 1), _percent(median_of(every, "gpu"))]


def _full_speed(by_pace: Mapping[str, Sequence[Outcome]], empty: Sequence[Outcome]) -> list[str]:
    """Return the speed, and its share of the empty world's, if it is known what the robots did."""
    free, beside = by_pace.get("free", ()), by_pace.get("beside", ())
    speed = _plain(median_of([*free, *beside], "speed"), 1) or "-"
    if not known([*free, *beside], "driven"):
        return [speed, "-"]
    return [speed, _share(beside) or _quotient(median_of(free, "speed"), median_of(empty, "speed"))]


def _robots(by_pace: Mapping[str, Sequence[Outcome]]) -> list[str]:
    """Return the cells of what the robots did, at one pace after the other."""
    told = [outcomes for outcomes in by_pace.values() if known(outcomes, "driven")]
    ways = [
        f"{_plain(mean_of(outcomes, 'driven'), 2)} m in {_plain(mean_of(outcomes, 'simulated'), 0)} s"
        for outcomes in told
    ]
    stuck, covered = ([_percent(mean_of(outcomes, name)) for outcomes in told] for name in ("stuck", "covered"))
    tipped = [_plain(mean_of(outcomes, "tipped"), 2) for outcomes in told]
    return [" / ".join(filter(None, texts)) for texts in (ways, stuck, tipped, covered)]


def _incidents(by_pace: Mapping[str, Sequence[Outcome]]) -> list[str]:
    """Return the cells of what happened to robots and servers, at one pace after the other; attempts are a sum."""
    tried = [outcomes for outcomes in by_pace.values() if outcomes]
    off, impossible = ([_percent(mean_of(outcomes, name)) for outcomes in tried] for name in ("off", "impossible"))
    attempts = [_plain(sum(counts)) if (counts := known(outcomes, "attempts")) else "" for outcomes in tried]
    return [" / ".join(filter(None, texts)) for texts in (off, impossible, attempts)]


def _of_the_starved(starved: Sequence[Outcome]) -> str:
    """Return how many trials were starved, and how little of the machine they had at worst."""
    trials = f"{len(starved)} {'trial' if len(starved) == 1 else 'trials'}"
    cpu, machine = min(known(starved, "cpu"), default=None), max(known(starved, "machine"), default=None)
    simulated = min(known(starved, "simulated"), default=None)
    return ", ".join(
        [
            trials,
            *([f"with {_percent(cpu)} of a core or more"] if cpu is not None else []),
            *([f"{simulated:.3g} s of simulation time or more"] if simulated is not None else []),
            *([f"the machine's load up to {_percent(machine)}"] if machine is not None else []),
        ]
    )


def _blocks(size: int) -> str:
    """Return the size of a map in words."""
    return f"{size} x {size}" if size else "empty"


def _share(beside: Sequence[Outcome]) -> str:
    """Return the share of the empty world's speed, simulated in turns with it, and its standard error."""
    shares = known(beside, "share")
    if len(shares) < 2:
        return "".join(f"{share:.2f}" for share in shares)
    return f"{median(shares):.2f} ± {standard_error(shares):.2f}"


def _quotient(speed: float | None, usual: float | None) -> str:
    return f"{speed / usual:.2f}" if speed and usual else "-"


def _empty(plan: ExperimentPlan, results: Results, row: TableRow) -> Sequence[Outcome]:
    """Return the outcomes of these robots in an empty world at full speed, of this row or else of a similar one."""
    alike = _alike(plan, row)
    return next((outcomes for index in alike if (outcomes := outcomes_of(results, index, 0, "free"))), ())


def _alike(plan: ExperimentPlan, row: TableRow) -> Iterator[int]:
    """Yield the numbers of the rows with the same robots and simulator, the row itself first."""
    for index, other in sorted(enumerate(plan.rows), key=lambda numbered: numbered[1] is not row):
        if (other.robot, other.robots, other.simulator) == (row.robot, row.robots, row.simulator):
            yield index


def _line(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cells) + " |"


def _percent(share: float | None) -> str:
    """Return a share as whole percents, or as tenths if it is small."""
    return "" if share is None else f"{share * 100:.{0 if share >= 0.1 or not share else 1}f} %"


def _plain(value: float | None, digits: int = 4) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.{digits}f}".rstrip("0").rstrip(".") if digits > 2 else f"{value:.{digits}f}"


# The picture: real-time factor, speed and memory over the side of the map.


_ASIDE = 0.006
"""Distance between curves, as a share of the largest map: equal figures would hide one another."""


class _Point(NamedTuple):
    """A figure of a cell: the side of the map, the value with its limits, and whether the robots rested."""

    size: float
    low: float
    value: float
    high: float
    rested: bool


def plot(plan: ExperimentPlan, results: Results) -> bytes:
    """Draw a PNG with a curve per row: points with the least and the most of all trials, and the paper's RTF.

    A point is hollow where the robots rested for most of the time.
    """
    from matplotlib.figure import Figure

    # Three axes, each with the curves of all rows; they have one legend, below.
    figure = Figure(figsize=(15, 5.5), dpi=100, layout="constrained")
    rtf, speed, memory = figure.subplots(1, 3)
    for index, row in enumerate(plan.rows):
        label = row_label(plan, row)
        _curve(rtf, index, plan, _rtf_points(plan, results, index), label)
        _curve(speed, index, plan, _points(plan, results, index, "speed"), label)
        _curve(memory, index, plan, _points(plan, results, index, "memory"), label)
    _draw_published(rtf, plan)
    _finish(rtf, "real-time factor: least, mean, most")
    _finish(speed, "simulated seconds per second of CPU")
    _finish(memory, "memory of the simulator [MB]")
    handles, labels = speed.get_legend_handles_labels()
    extra = [entry for entry in zip(*rtf.get_legend_handles_labels(), strict=True) if entry[1] not in labels]
    names = [*zip(handles, labels, strict=True), *extra]
    if names:
        figure.legend(*zip(*names, strict=True), loc="outside lower center", ncols=2)
    figure.suptitle(
        "bars: the least and the most of all trials; hollow: robots that rested, stuck for most of the time"
    )
    return encoded(figure, "png")


def _rtf_points(plan: ExperimentPlan, results: Results, index: int) -> list[_Point]:
    pace = next((pace for pace in plan.paces if pace in IN_REAL_TIME), "real")
    by_size = {size: outcomes_of(results, index, size, pace) for size in plan.rows[index].sizes}
    limits = {size: rtf_limits(outcomes) for size, outcomes in by_size.items()}
    return [_Point(size, *three, rested=rested(by_size[size])) for size, three in limits.items() if three]


def _points(plan: ExperimentPlan, results: Results, index: int, name: str) -> list[_Point]:
    """Return the medians of a figure, at full speed if that was tried."""
    pace = next((pace for pace in ("free", "beside") if pace in plan.paces), plan.paces[0])
    by_size = {size: outcomes_of(results, index, size, pace) for size in plan.rows[index].sizes}
    values = {size: known(outcomes, name) for size, outcomes in by_size.items()}
    return [_Point(size, min(v), median(v), max(v), rested(by_size[size])) for size, v in values.items() if v]


def _curve(axes: Axes, index: int, plan: ExperimentPlan, points: Sequence[_Point], label: str) -> None:
    """Points with their limits; moved a little aside, each curve by another way."""
    if not points:
        return
    aside = (index - (len(plan.rows) - 1) / 2) * _ASIDE * max(size for row in plan.rows for size in row.sizes)
    x = [point.size + aside for point in points]
    spread = [[point.value - point.low for point in points], [point.high - point.value for point in points]]
    colour = f"C{index % 10}"
    value = [point.value for point in points]
    axes.errorbar(x, value, yerr=spread, fmt="-", color=colour, capsize=3, label=label)
    faces = ["white" if point.rested else colour for point in points]
    axes.scatter(x, value, s=36, facecolors=faces, edgecolors=colour, zorder=3)


def _draw_published(axes: Axes, plan: ExperimentPlan) -> None:
    """The paper's least and most real-time factor, for the rows that are the paper's."""
    published = {
        (size, figures.rtf_limits)
        for row in plan.rows
        for size, figures in published_figures(row).items()
        if size in row.sizes
    }
    if published:
        sizes, limits = zip(*sorted(published), strict=True)
        middle = [fmean(ends) for ends in limits]
        half = [(most - least) / 2 for least, most in limits]
        axes.errorbar(
            sizes, middle, yerr=half, fmt="D", color="black", markerfacecolor="none", capsize=5, label="paper"
        )


def _finish(axes: Axes, title: str) -> None:
    """Axes from zero, with room around every point."""
    axes.set(xlabel="side of the map [blocks], 0: empty", title=title)
    axes.margins(x=0.06)
    if axes.has_data():
        axes.set_ylim(0, 1.08 * axes.dataLim.ymax)
    axes.grid(visible=True, alpha=0.3)
