"""The outcomes of an experiment as a Markdown page, CSV and a picture, next to the figures that the paper published.

A cell of the table has several trials. Costs are medians, which a noisy hour moves little, with the means next to them
where the paper has means; real-time factors are the least, the mean and the most of all; figures of robots are means,
as their routes are random. The error of a share is the standard error of the median of normally distributed values,
sqrt(pi / 2 / n) times their standard deviation.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import fields
from functools import partial
from itertools import product
from math import pi, sqrt
from pathlib import Path
from statistics import fmean, median, stdev
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from rsegen.experiments.plan import IN_REAL_TIME, LARGER, PACES, Cell, ExperimentPlan, TableRow
from rsegen.experiments.trial import STARVED, Outcome, Results
from rsegen.experiments.trial_server import SOURCES
from rsegen.field.steps import steps
from rsegen.pictures.preview import encoded
from rsegen.recipe.building import build
from rsegen.robots.base import ROBOTS
from rsegen.simulators.base import SIMULATORS
from rsegen.simulators.embedded import EMBEDDED

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class PublishedFigures(NamedTuple):
    """A row of the paper's table 2, as printed."""

    rtf: str
    cpu: str
    memory: str


class PublishedRow(NamedTuple):
    """The robots of a row of the paper, and the unit and levels of its maps."""

    robot: str
    robots: int
    unit_cm: float
    levels: int


# The paper's table 2, and its computer, as printed.
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
    size: PublishedFigures(rtf, "8 %", "0.8 GB")
    for size, rtf in ((0, "0.98-1"), (10, "0.97-1"), (20, "0.97-1"), (40, "0.96-1"), (60, "0.95-1"), (80, "0.92-1"))
}

FIGURES: Mapping[PublishedRow, Mapping[int, PublishedFigures]] = {
    PublishedRow("crawler", 1, 10, 5): {size: _CRAWLER[size] for size in (0, 10, 20)},
    PublishedRow("crawler", 1, 10, 10): {size: _CRAWLER[size] for size in (0, 40, 60, 80)},
    PublishedRow("burger", 3, 1, 5): _BURGERS,
}
"""Figures by robots and maps, and by the side of the map in blocks. The tracked robot had an arm, five cameras
and a lidar."""


def published_figures(row: TableRow) -> Mapping[int, PublishedFigures]:
    """Return the paper's figures for the robots and maps of a row, by size.

    The paper used Gazebo Classic. Its maps of 10 x 10 blocks have a single obstacle, and all maps have frames as high
    as a unit, as in its figure 7. It has no random blocks.
    """
    design = {"frame_height_cm": 10, **(row.recipe or {})}
    if (
        row.simulator not in (None, "classic")
        or row.maps == "random"
        or design != {"boundary": "divided", "frame_height_cm": row.unit_cm}
    ):
        return {}
    figures = FIGURES.get(PublishedRow(row.robot, row.robots, row.unit_cm, row.levels), {})
    return {size: figure for size, figure in figures.items() if not size or (size > SINGLE) == (row.maps == LARGER)}


SINGLE = 10
"""Side in blocks of the paper's worlds that have a single obstacle."""


RESTING = 0.5
"""Mean share of the time that robots of a cell are stuck, beyond which they count as resting."""


def outcomes_of(results: Results, row: int, size: int, pace: str) -> Sequence[Outcome]:
    """Return the outcomes of a cell; none if it was not tried yet."""
    return results.get(Cell(row=row, size=size, pace=pace), [])


def values_of(outcomes: Iterable[Outcome], name: str) -> list[float]:
    """Return the values of a figure, of all outcomes that have it."""
    return [value for value in (getattr(outcome, name) for outcome in outcomes) if value is not None]


def median_of(outcomes: Iterable[Outcome], name: str) -> float | None:
    """Return the median of a figure of outcomes; None if none has it."""
    values = values_of(outcomes, name)
    return median(values) if values else None


def mean_of(outcomes: Iterable[Outcome], name: str) -> float | None:
    """Return the mean of a figure of outcomes; None if none has it."""
    values = values_of(outcomes, name)
    return fmean(values) if values else None


def rtf_limits(outcomes: Sequence[Outcome]) -> tuple[float, float, float] | None:
    """Return the least, the mean and the most real-time factor over all trials; None without any."""
    least, mean, most = (values_of(outcomes, name) for name in ("rtf_min", "rtf", "rtf_max"))
    return (min(least), fmean(mean), max(most)) if least and mean and most else None


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
"""Label of a line of a table -> the paces whose figures it has."""

_RENDERING = ("frames per s", "GPU")
_INCIDENTS = ("off the map", "impossible", "attempts")
"""Columns that a table has only if their figures were measured."""

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
    """Return the text of trials.csv, a line per trial, with the numbers that the files of its tracks have."""
    names = [field.name for field in fields(Outcome)]
    text = io.StringIO()
    lines = csv.writer(text, lineterminator="\n")  # the name of a robot's file may have a comma
    lines.writerow(["row", "trial", "simulator", "robot", "robots", "size", "pace", *names])
    for cell, outcomes in results.items():
        row = plan.rows[cell.row]
        of_cell = [row.simulator or "", row.robot, row.robots, cell.size, cell.pace]
        for trial, outcome in enumerate(outcomes):
            lines.writerow([cell.row + 1, trial, *of_cell, *(_plain(getattr(outcome, name)) for name in names)])
    return text.getvalue()


def _head(plan: ExperimentPlan, results: Results, machine: Mapping[str, str], command: str) -> Iterator[str]:
    yield f"# Experiment: {plan.name}\n"
    # A warning comes before all figures; then sentences only on what this plan and its results have.
    if still := dict.fromkeys(_still(plan, results)):
        yield f"**Robots stood still**, stuck for more than half of the time, where {MARK} is: {'; '.join(still)}.\n"
    yield f"Made by `{command}`: {plan.repeats} {'trial' if plan.repeats == 1 else 'trials'} per cell, in mixed"
    paces = " and ".join(_TITLES[pace] for pace in plan.paces)
    yield f"order; robots drive randomly for {plan.seconds:g} seconds of wall time, {paces}."
    yield "RTF: the smallest, the largest and the mean value of all trials. Robots: means per robot over all trials, in"
    yield "the simulation time of one trial. Everything else: medians of the trials."
    if any(map(published_figures, plan.rows)):
        yield "The paper has means of three runs of CPU and memory; next to its figures, our means are in brackets."
    if len(mixed := [pace for pace in plan.paces if pace in _LINES[""]]) > 1:
        yield f"If a cell has several figures, they are {' / '.join(_TITLES[pace] for pace in mixed)}."
    if _has_incidents(results):
        yield "Off the map: share of the robots that left it; they drove on. Impossible: share that did what no robot"
        yield "can, with which their other figures end. Attempts: servers that the trials took, as those that fail are"
        yield "replaced."
    if not set(plan.paces) & set(SOURCES):
        yield "No window and no camera, so no frames per second."
    yield "\n| machine | |\n|---|---|"
    yield from (f"| {name} | {value} |" for name, value in machine.items())
    if any(map(published_figures, plan.rows)):
        yield f"\nThe paper's computer: {COMPUTER}; with a window. Its RTF: smallest and largest value of three runs."
    yield ""


def _still(plan: ExperimentPlan, results: Results) -> Iterator[str]:
    """Yield the robots and maps of rows in which robots rested, with the reason if it is known."""
    for index, row in enumerate(plan.rows):
        sizes = [size for size in row.sizes if _rested_at(plan, results, index, size)]
        if not sizes:
            continue
        name = f"{row.robots} {Path(row.robot).name}"
        # First the robot alone, on an empty world; only if it drives there can the map be the reason.
        if any(_rested_at(plan, results, alike, 0) for alike in _alike(plan, row)):
            where = f" in {_title(row)}" if _title(row) else ""
            yield f"{name}{where}, without a map too, so maps are not the reason"
            continue
        robot, smallest = ROBOTS.get(row.robot), min(sizes)
        above = steps(build(row.map_of(smallest, plan.seed))).share_above(robot.climbs) if robot else None
        if robot and above:
            too_high = f"{above:.0%} of the steps are higher than the {100 * robot.climbs:g} cm that it climbs"
            yield f"{row.robots_and_maps}, as {too_high}"
        else:
            yield f"{row.robots_and_maps}, for a reason that is not known"


def _rested_at(plan: ExperimentPlan, results: Results, index: int, size: int) -> bool:
    """Return whether the robots of a row rested at a size, at any pace."""
    return any(rested(outcomes_of(results, index, size, pace)) for pace in plan.paces)


def _has_incidents(results: Results) -> bool:
    """Return whether incidents and attempts were recorded; trials of earlier versions lack them."""
    return any(values_of(outcomes, "attempts") for outcomes in results.values())


def _title(row: TableRow) -> str:
    simulator = SIMULATORS.get(row.simulator or "") or EMBEDDED.get(row.simulator or "")
    return simulator.title if simulator else ""


def _table(plan: ExperimentPlan, numbers: Sequence[int], results: Results) -> Iterator[str]:
    """Yield the table of rows that differ by the simulator only, and its footnotes."""
    rows = {index: plan.rows[index] for index in numbers}
    several, first = len(rows) > 1, plan.rows[numbers[0]]
    yield f"## {first.label}{'' if several or not _title(first) else f', in {_title(first)}'}\n"
    rendering = bool(set(SOURCES) & set(plan.paces)) or any(values_of(outcomes, "gpu") for outcomes in results.values())
    unknown = (*(() if rendering else _RENDERING), *(() if _has_incidents(results) else _INCIDENTS))
    titles = [title for title in _cells({}, ()) if title not in unknown]
    paper = _PAPER if any(map(published_figures, rows.values())) else ()
    columns = [*["simulator"] * several, "blocks", *titles, *paper]
    yield f"{_line(columns)}\n{'|---' * len(columns)}|"
    # A line for each size, row and kind of pace that was tried.
    for size in dict.fromkeys(size for row in rows.values() for size in row.sizes):
        for (index, row), (pace_label, paces) in product(rows.items(), _LINES.items()):
            by_pace = {pace: outcomes_of(results, index, size, pace) for pace in PACES if pace in paces}
            if not any(by_pace.values()):
                continue
            label = [", ".join(filter(None, (f"{size} x {size}" if size else "empty", pace_label)))]
            label += [MARK] if any(map(rested, by_pace.values())) else []
            label += [STARVED_MARK] if any(map(_starved, by_pace.values())) else []
            texts = _cells(by_pace, _empty(plan, results, row), with_means=bool(paper))
            published = published_figures(row).get(size) if paper and not pace_label else None
            cells = [" ".join(label), *map(texts.__getitem__, titles), *(published or [""] * len(paper))]
            yield _line([*[_title(row)] * several, *cells])
    tried = [outcomes for cell, outcomes in results.items() if cell.row in rows]
    if any(map(rested, tried)):
        yield f"\n{_RESTED}"
    if starved := [outcome for outcomes in tried for outcome in _starved(outcomes)]:
        yield f"\n{_STARVED}{_of_the_starved(starved)}."
    if not all(values_of(outcomes, "driven") for outcomes in tried):
        yield f"\n{_UNKNOWN}"
    yield ""


def _cells(
    by_pace: Mapping[str, Sequence[Outcome]], empty: Sequence[Outcome], *, with_means: bool = False
) -> dict[str, str]:
    """Return the cells of a line by the titles of their columns.

    empty: the outcomes of the empty world; with_means: add means, in brackets, to figures that are means in the paper
    Speeds are compared with the empty world only if the drives of the robots were recorded.
    """
    # Costs are medians of the paces in real time, or of all; figures of robots are given for each pace.
    every = [outcome for outcomes in by_pace.values() for outcome in outcomes]
    real = [outcome for pace in IN_REAL_TIME for outcome in by_pace.get(pace, ())]
    quick = [outcome for pace in ("free", "beside") for outcome in by_pace.get(pace, ())]
    rtf, cpu = rtf_limits(real), median_of(real, "cpu")
    speed, usual = median_of(by_pace.get("free", ()), "speed"), median_of(empty, "speed")
    share = _share(by_pace.get("beside", ())) or (f"{speed / usual:.2f}" if speed and usual else "")

    def beside_mean(text: Callable[[float | None], str], of: Sequence[Outcome], name: str) -> str:
        middle, mean = text(median_of(of, name)), mean_of(of, name)
        return f"{middle} (mean {text(mean)})" if with_means and mean is not None else middle

    def at_each_pace(text: Callable[[Sequence[Outcome]], str]) -> str:
        texts = [text(outcomes) for outcomes in by_pace.values() if outcomes]
        return " / ".join(part or "-" for part in texts) if any(texts) else ""

    def means(name: str) -> str:
        return at_each_pace(lambda outcomes: _percent(mean_of(outcomes, name)))

    def way(outcomes: Sequence[Outcome]) -> str:
        driven, seconds = mean_of(outcomes, "driven"), mean_of(outcomes, "simulated")
        return f"{_plain(driven, 2)} m in {_plain(seconds, 0)} s" if driven is not None else ""

    return {
        "RTF min-max (mean)": f"{rtf[0]:.2f}-{rtf[2]:.2f} ({rtf[1]:.2f})" if rtf else "-",
        "CPU: server": f"{cpu * 100:.0f} % of a core" if cpu is not None else "-",
        "CPU: machine": beside_mean(_percent, real, "machine") or "-",
        "memory": beside_mean(lambda value: f"{_plain(value, 0)} MiB", every, "memory"),
        "load": f"{_plain(median_of(every, 'load'), 1)} s",
        "frames per s": _plain(median_of(every, "fps"), 1),
        "GPU": _percent(median_of(every, "gpu")),
        "simulated s per CPU s": _plain(median_of(quick, "speed"), 1) or "-",
        "of the empty world's": (share if values_of(quick, "driven") else "") or "-",
        "driven": at_each_pace(way),
        "stuck": means("stuck"),
        "tipped": at_each_pace(lambda outcomes: _plain(mean_of(outcomes, "tipped"), 2)),
        "covered": means("covered"),
        "off the map": means("off"),
        "impossible": means("impossible"),
        "attempts": at_each_pace(lambda outcomes: _plain(sum(values_of(outcomes, "attempts")) or None)),
    }


def _starved(outcomes: Sequence[Outcome]) -> list[Outcome]:
    return [outcome for outcome in outcomes if outcome.starved]


def _of_the_starved(starved: Sequence[Outcome]) -> str:
    """Return the number of starved trials, and their least share of the machine, in words."""
    cpu, simulated = (min(values_of(starved, name), default=None) for name in ("cpu", "simulated"))
    machine = max(values_of(starved, "machine"), default=None)
    facts = [f"{len(starved)} {'trial' if len(starved) == 1 else 'trials'}"]
    facts += [f"with {_percent(cpu)} of a core or more"] if cpu is not None else []
    facts += [f"{simulated:.3g} s of simulation time or more"] if simulated is not None else []
    facts += [f"the machine's load up to {_percent(machine)}"] if machine is not None else []
    return ", ".join(facts)


def _share(beside: Sequence[Outcome]) -> str:
    """Return the speed as a share of the empty world's, simulated in turns with it, and its standard error."""
    shares = values_of(beside, "share")
    if len(shares) < 2:
        return "".join(f"{share:.2f}" for share in shares)
    return f"{median(shares):.2f} ± {sqrt(pi / 2 / len(shares)) * stdev(shares):.2f}"


def _empty(plan: ExperimentPlan, results: Results, row: TableRow) -> Sequence[Outcome]:
    """Return the outcomes of a row's robots in an empty world at full speed, of this row or else of a similar one."""
    alike = _alike(plan, row)
    return next((outcomes for index in alike if (outcomes := outcomes_of(results, index, 0, "free"))), ())


def _alike(plan: ExperimentPlan, row: TableRow) -> Iterator[int]:
    """Yield the indices of the rows with the same robots and simulator, the row itself first."""
    for index, alike in sorted(enumerate(plan.rows), key=lambda numbered: numbered[1] is not row):
        if (alike.robot, alike.robots, alike.simulator) == (row.robot, row.robots, row.simulator):
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
"""Distance along x between curves, as a share of the largest map: equal figures would hide each other."""


_Limits = Callable[[Sequence[Outcome]], tuple[float, float, float] | None]
"""Function that returns the least, the middle and the most of a figure of outcomes, or None."""


class _Point(NamedTuple):
    """A figure of a cell: the side of the map, the value with its limits, and whether the robots rested."""

    size: float
    low: float
    value: float
    high: float
    rested: bool


def plot(plan: ExperimentPlan, results: Results) -> bytes:
    """Draw a PNG with a curve per row: points with the least and the most of all trials, and the paper's RTF.

    A point is hollow where the robots were stuck for most of the time. Plans without a pace in real time have no RTF.
    """
    from matplotlib.figure import Figure

    # Two or three axes, each with the curves of all rows; they have one legend, below.
    real = next((pace for pace in plan.paces if pace in IN_REAL_TIME), None)
    quick = next((pace for pace in ("free", "beside") if pace in plan.paces), plan.paces[0])
    panels: dict[str, tuple[str, _Limits]] = {"real-time factor: least, mean, most": (real, rtf_limits)} if real else {}
    panels["simulated seconds per second of CPU"] = quick, partial(_limits, name="speed")
    panels["memory of the simulator [MiB]"] = quick, partial(_limits, name="memory")
    figure = Figure(figsize=(5 * len(panels), 5.5), dpi=100, layout="constrained")
    several = len({row.simulator for row in plan.rows}) > 1
    handles: dict[str, Any] = {}
    for axes, (title, (pace, limits)) in zip(figure.subplots(1, len(panels)), panels.items(), strict=True):
        for index, row in enumerate(plan.rows):
            label = row.label + (f", {_title(row)}" if several else "")
            _curve(axes, index, plan, _points(plan, results, index, pace, limits), label)
        if limits is rtf_limits:
            _draw_published(axes, plan)
        _finish(axes, title)
        handles |= {label: handle for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)}
    if handles:
        figure.legend(list(handles.values()), list(handles), loc="outside lower center", ncols=2)
    figure.suptitle("bars: least and most of all trials; hollow markers: robots stuck most of the time")
    return encoded(figure, "png")


def _points(
    plan: ExperimentPlan,
    results: Results,
    index: int,
    pace: str,
    limits: _Limits,
) -> list[_Point]:
    """Return the points of a row at a pace, for the sizes whose outcomes have the figure."""
    by_size = {size: outcomes_of(results, index, size, pace) for size in plan.rows[index].sizes}
    return [_Point(size, *ends, rested(trials)) for size, trials in by_size.items() if (ends := limits(trials))]


def _limits(outcomes: Sequence[Outcome], name: str) -> tuple[float, float, float] | None:
    """Return the least, the median and the most of a figure; None if no outcome has it."""
    values = values_of(outcomes, name)
    return (min(values), median(values), max(values)) if values else None


def _curve(axes: Axes, index: int, plan: ExperimentPlan, points: Sequence[_Point], label: str) -> None:
    """Draw points with their limits, each curve a little to the side of the others."""
    if not points:
        return
    aside = (index - (len(plan.rows) - 1) / 2) * _ASIDE * max(size for row in plan.rows for size in row.sizes)
    size, low, value, high, _ = np.array(points).T
    again, hue = divmod(index, 10)  # there are ten colours, and then other lines and markers
    colour, line, marker = f"C{hue}", ("-", "--", ":")[again % 3], "os^"[again % 3]
    axes.errorbar(size + aside, value, yerr=[value - low, high - value], fmt=line, color=colour, capsize=3, label=label)
    faces = ["white" if point.rested else colour for point in points]
    axes.scatter(size + aside, value, s=36, marker=marker, facecolors=faces, edgecolors=colour, zorder=3)


def _draw_published(axes: Axes, plan: ExperimentPlan) -> None:
    """Draw the paper's least and most real-time factor, for rows that the paper has too."""
    published = {
        (size, *map(float, figures.rtf.split("-")))
        for row in plan.rows
        for size, figures in published_figures(row).items()
        if size in row.sizes
    }
    if published:
        size, least, most = np.array(sorted(published)).T
        middle, half = (least + most) / 2, (most - least) / 2
        axes.errorbar(size, middle, yerr=half, fmt="D", color="black", mfc="none", capsize=5, label="paper")


def _finish(axes: Axes, title: str) -> None:
    """Set labels and limits: from zero up, with room around every point."""
    axes.set(xlabel="side of the map [blocks], 0: empty", title=title)
    axes.margins(x=0.06)
    if axes.has_data():
        axes.set_ylim(0, 1.08 * axes.dataLim.ymax)
    axes.grid(visible=True, alpha=0.3)
