"""The ways of robots on the plan of a map, as a picture."""

from __future__ import annotations

import io
from collections.abc import Mapping

from rsegen.drawing import draw_plan
from rsegen.driving.trip import Track
from rsegen.scene import Scene


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
    axes.legend(loc="upper right")
    axes.set_title(f"{scene.name}: where they drove")
    stream = io.BytesIO()
    figure.savefig(stream, format="png")
    return stream.getvalue()
