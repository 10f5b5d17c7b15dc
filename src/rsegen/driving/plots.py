"""Pictures of drives on the plan of their map, for a column of a paper: legible in grey, and no line hides a height.

    map, trajectories --trajectory_plot--> drive.png, drive.pdf
    map, prediction ----prediction_plot--> the picture of `rsegen predict -o`

Heights are colours with a legend, not numbers in the cells, as lines would run over these. Lines have a white rim, so
that they are seen on blocks of every colour, and differ in dashes and ends as well as in colour.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from rsegen.driving.drive_metrics import Trajectory
from rsegen.driving.prediction import Prediction
from rsegen.driving.routes import PlannedWay
from rsegen.field.stepfield import Array
from rsegen.pictures.plan import draw_cells, legend_swatches
from rsegen.pictures.preview import COLUMN, DPI, PAPER, figure_bytes, in_rows
from rsegen.scene.scene import Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_RIM, _RIM_SHARE, _MARGIN = 0.1, 0.02, 1.5
"""Width, metres, of the ground around the map that is drawn: the least, the least as a share of the longer side of the
map, and the largest, so that the map stays large; more, up to twice the side of the map, if a robot starts there."""

_NARROW, _LOW = 1.0, 0.5
"""Inches along x and y below which only the middle of an axis has a number, as others would overlap."""

_TALLEST = 7.0
"""Inches of a picture at most, in which its caption has room on a page."""

_HEIGHTS, _ACROSS = 6, 4
"""Heights in the legend at most, more are every second, third, ...; and its columns at most."""

_LINES = (
    *(("black", "-"), ("#d7191c", (0, (6, 1))), ("#2c7bb6", (0, (3, 1))), ("#7b3294", (0, (6, 1, 1, 1)))),
    *(("#e66101", (0, (3, 1, 1, 1))), ("#01665e", (0, (1, 1)))),
)
"""Colour and dashes of each robot; the seventh has those of the first again."""

_CROSSED, _ENDED = ("#1a9850", "-"), ("#d73027", (0, (4, 1)))
"""Colour and dashes of drives that crossed, and of those that did not, which also end at a cross."""


def trajectory_plot(
    scene: Scene,
    trajectories: Mapping[str, Trajectory],
    way: PlannedWay | None = None,
    format: str = "png",  # noqa: A002  # matplotlib's word
) -> bytes:
    """Return a picture: each trajectory begins at a ring and ends at a dot, or at a cross if the robot has tipped over.

    Rows that are not finite are left out. The file carries the map's recipe.
    """
    from matplotlib import rc_context

    with rc_context(PAPER):
        points = [trajectory.rows[:, 1:3] for trajectory in trajectories.values()]
        figure, axes = _plan(scene, points)
        if way:
            _draw_way(axes, way.points)
        for index, (name, trajectory) in enumerate(trajectories.items()):
            colour, dashes = _LINES[index % len(_LINES)]
            line = trajectory.rows[:, 1:3]
            _draw_line(axes, line, colour, dashes, name)
            axes.plot(*line[:1].T, "o", color=colour, markersize=5, markerfacecolor="white", markeredgewidth=1)
            end = "X" if trajectory.has_tipped else "o"
            axes.plot(*line[-1:].T, end, color=colour, markersize=5, markeredgecolor="white", markeredgewidth=0.5)
        _draw_legend(figure, axes, scene)
        return figure_bytes(figure, scene, format)


def prediction_plot(scene: Scene, robot: str, prediction: Prediction, format: str = "png") -> bytes:  # noqa: A002  # matplotlib's word
    """Return a picture of all drives of a prediction: those that do not cross end at a cross.

    The file carries the map's recipe.
    """
    from matplotlib import rc_context

    with rc_context(PAPER):
        counts = f"{prediction.crossed} of {prediction.drives} drives"
        title = f"{scene.name}, {robot}:\ncrosses with probability {prediction.probability:.2f} ({counts})"
        figure, axes = _plan(scene, [outcome.path for outcome in prediction.outcomes], title)
        named = set()  # of the drives of an outcome one is in the legend
        for outcome in prediction.outcomes:
            colour, dashes = _ENDED if outcome.reason else _CROSSED
            label = "did not cross" if outcome.reason else "crossed"
            _draw_line(axes, outcome.path, colour, dashes, "" if label in named else label)
            named.add(label)
            if outcome.reason:
                cross: dict[str, Any] = {"markersize": 5, "markeredgecolor": "white", "markeredgewidth": 0.5}
                axes.plot(*outcome.path[-1:].T, "X", color=colour, **cross)
        if prediction.way:
            _draw_way(axes, prediction.way.points)
        _draw_legend(figure, axes, scene)
        return figure_bytes(figure, scene, format)


def _plan(scene: Scene, lines: list[Array], title: str = "") -> tuple[Figure, Axes]:
    """Return a figure as wide as a column, and its plan of the map with the ground on which these lines are."""
    from matplotlib.figure import Figure

    (left, right), (low, high) = (_limits(scene.field.extent, lines, axis) for axis in (0, 1))
    around = 0.85 + (0.35 if title else 0)
    scale = min((COLUMN - 0.5) / (right - left), (_TALLEST - around) / (high - low))
    height = scale * (high - low) + around
    figure = Figure(figsize=(COLUMN, height), dpi=DPI, layout="constrained")
    axes = figure.subplots()
    draw_cells(axes, scene)
    axes.set(xlim=(left, right), ylim=(low, high), xlabel="x [m]", ylabel="y [m]", title=title)
    if scale * (right - left) < _NARROW:
        axes.set_xticks([0])
    if scale * (high - low) < _LOW:
        axes.set_yticks([0])
    return figure, axes


def _limits(extent: tuple[float, float], lines: list[Array], axis: int) -> tuple[float, float]:
    """Return the limits of an axis: the map, where robots start, and the lines near it."""
    along = [line[np.isfinite(line[:, axis]), axis] for line in lines]
    rim, side = max(_RIM, _RIM_SHARE * max(extent)), extent[axis]
    start = max((abs(float(values[0])) for values in along if len(values)), default=0.0) + rim
    half, far = side / 2 + rim, side / 2 + max(_MARGIN, min(start - side / 2, 2 * side))
    low = min((values.min(initial=0.0) for values in along), default=0.0) - rim
    high = max((values.max(initial=0.0) for values in along), default=0.0) + rim
    return max(min(low, -half), -far), min(max(high, half), far)


def _draw_line(axes: Axes, line: Array, colour: str, dashes: Any, label: str) -> None:
    axes.plot(*line.T, color="white", linewidth=2.2)
    axes.plot(*line.T, color=colour, linewidth=1.1, linestyle=dashes, label=label or "_")


def _draw_way(axes: Axes, points: Array) -> None:
    """Draw a planned way, thin and dotted, over what was driven."""
    axes.plot(*points.T, color="white", linewidth=1.6)
    axes.plot(*points.T, color="black", linewidth=0.8, linestyle=":", label="planned way")


def _draw_legend(figure: Figure, axes: Axes, scene: Scene) -> None:
    """Draw the legend of lines, and of the colours of heights, below the plan."""
    lines, _ = axes.get_legend_handles_labels()
    heights = legend_swatches(scene, _HEIGHTS)
    room: dict[str, float] = {"columnspacing": 1.0, "handlelength": 2.4, "handletextpad": 0.5}
    for columns in range(_ACROSS, 0, -1):  # long names of robots need fewer than names of heights
        entries = in_rows([*lines, *heights], columns)
        legend = figure.legend(handles=entries, loc="outside lower center", ncols=columns, frameon=False, **room)
        if columns == 1 or legend.get_window_extent().width <= figure.bbox.width:
            break
        legend.remove()
