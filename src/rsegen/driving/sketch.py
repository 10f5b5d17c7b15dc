"""The ways of robots on the plan of a map, as a picture."""

from __future__ import annotations

import io
from collections.abc import Mapping

from rsegen.drawing import draw_plan
from rsegen.driving.trip import Track
from rsegen.scene import Scene

_MARGIN = 1.5
"""Metres about the map that are drawn."""


def sketch(scene: Scene, tracks: Mapping[str, Track]) -> bytes:
    """A PNG: each way begins at a ring and ends at a dot, or at a cross where the robot has tipped over."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8, 8), dpi=100, layout="constrained")
    axes = figure.subplots()
    draw_plan(axes, scene)
    for number, (name, track) in enumerate(tracks.items()):
        x, y = track.rows[:, 1], track.rows[:, 2]
        colour = f"C{number % 10}"
        axes.plot(x, y, color="white", linewidth=4)
        axes.plot(x, y, color=colour, linewidth=2, label=name)
        axes.plot(x[:1], y[:1], "o", color=colour, markersize=10, markerfacecolor="white", markeredgewidth=2)
        axes.plot(x[-1:], y[-1:], "X" if track.has_tipped else "o", color=colour, markersize=9, markeredgecolor="white")
    half_x, half_y = (along / 2 + _MARGIN for along in scene.field.extent)
    axes.set(xlim=(-half_x, half_x), ylim=(-half_y, half_y))
    axes.legend(loc="upper right")
    axes.set_title(f"{scene.name}: where they drove")
    stream = io.BytesIO()
    figure.savefig(stream, format="png")
    return stream.getvalue()
