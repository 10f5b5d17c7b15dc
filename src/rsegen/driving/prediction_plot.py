"""A picture of a prediction: the way and all drives on the plan of the map."""

from __future__ import annotations

from rsegen.driving.prediction import Prediction
from rsegen.pictures.plan import draw_plan
from rsegen.pictures.preview import figure_bytes, figure_of
from rsegen.scene.scene import Scene

_CROSSED, _ENDED = "#1a9850", "#d73027"
"""Colours of drives that crossed, and of those that did not, which a red-green blind person tells by the crosses."""


def prediction_plot(scene: Scene, found: Prediction, format: str = "png") -> bytes:  # noqa: A002  # matplotlib's word
    """Return the picture as the bytes of an image file, which carries the map's recipe.

    A drive that crossed is a green line, one that did not is red, and ends at a cross. The planned way is dashed.
    """
    along_x, along_y = scene.field.extent
    figure = figure_of(9, 8 * along_y / along_x + 1.2, 3, 14)
    axes = figure.subplots()
    draw_plan(axes, scene)
    for outcome in found.outcomes:
        colour = _ENDED if outcome.reason else _CROSSED
        axes.plot(*outcome.path.T, color="white", linewidth=3, alpha=0.5)
        axes.plot(*outcome.path.T, color=colour, linewidth=1.3)
        if outcome.reason:
            axes.plot(*outcome.path[-1:].T, "X", color=colour, markersize=9, markeredgecolor="white")
    if found.way:
        axes.plot(*found.way.points.T, color="white", linewidth=3)
        axes.plot(*found.way.points.T, color="black", linewidth=1.5, linestyle="--", label="planned way")
        axes.legend(loc="upper right")
    axes.autoscale_view()
    end = f"\nmost often ends: it {found.ends[0]}" if found.ends else ""
    counts = f"{found.crossed} of {found.drives} drives"
    axes.set_title(f"{scene.name}: crosses with probability {found.probability:.2f} ({counts}){end}")
    return figure_bytes(figure, scene, format)
