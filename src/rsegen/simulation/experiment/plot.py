"""The outcomes of an experiment as a picture: real-time factor, speed and memory over the side of the map."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import fmean, median
from typing import TYPE_CHECKING, NamedTuple

from rsegen.exporters.pictures.preview import encoded
from rsegen.simulation.experiment.plan import IN_REAL_TIME, ExperimentPlan
from rsegen.simulation.experiment.report import known, outcomes_of, published_figures, rested, row_label, rtf_limits
from rsegen.simulation.experiment.results import Results

if TYPE_CHECKING:
    from matplotlib.axes import Axes

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
