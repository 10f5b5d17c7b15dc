"""A picture of the trajectories of robots on the plan of a map."""

from __future__ import annotations

import io
from collections.abc import Mapping

from rsegen.exporters.pictures.plan import draw_plan
from rsegen.exporters.scene import Scene
from rsegen.simulation.driving.drive_metrics import Trajectory
from rsegen.simulation.driving.way import PlannedWay

_RIM, _MARGIN = 0.1, 1.5
"""Metres around the map that are drawn at least, and at most."""


def draw_trajectories(scene: Scene, trajectories: Mapping[str, Trajectory], way: PlannedWay | None = None) -> bytes:
    """A PNG: each trajectory begins at a ring and ends at a dot, or at a cross if the robot has tipped over.

    A planned way is a dashed line.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8, 8), dpi=100, layout="constrained")
    axes = figure.subplots()
    draw_plan(axes, scene)
    if way:
        axes.plot(*way.points.T, color="white", linewidth=3)
        axes.plot(*way.points.T, color="black", linewidth=1.5, linestyle="--", label="planned way")
    for number, (name, trajectory) in enumerate(trajectories.items()):
        x, y = trajectory.rows[:, 1], trajectory.rows[:, 2]
        colour = f"C{number % 10}"
        axes.plot(x, y, color="white", linewidth=4)
        axes.plot(x, y, color=colour, linewidth=2, label=name)
        axes.plot(x[:1], y[:1], "o", color=colour, markersize=10, markerfacecolor="white", markeredgewidth=2)
        axes.plot(
            x[-1:], y[-1:], "X" if trajectory.has_tipped else "o", color=colour, markersize=9, markeredgecolor="white"
        )
    axes.set(xlim=_limits(scene.field.extent[0], trajectories, 1), ylim=_limits(scene.field.extent[1], trajectories, 2))
    axes.legend(loc="upper right")
    axes.set_title(f"{scene.name}: trajectories")
    stream = io.BytesIO()
    figure.savefig(stream, format="png")
    return stream.getvalue()


def _limits(extent: float, trajectories: Mapping[str, Trajectory], column: int) -> tuple[float, float]:
    """The limits of an axis: the map, and the trajectories near it."""
    along = [trajectory.rows[:, column] for trajectory in trajectories.values()]
    half, far = extent / 2 + _RIM, extent / 2 + _MARGIN
    low, high = min(each.min() for each in along) - _RIM, max(each.max() for each in along) + _RIM
    return max(min(low, -half), -far), min(max(high, half), far)
