"""Pictures of ways across a map, of a robot or within limits of steps, with a map of what is reached."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from rsegen.pictures.plan import GROUND_GREY, boundary, draw_plan, legend_swatches, ramp, show_cells
from rsegen.pictures.preview import figure_bytes, figure_of
from rsegen.scene.scene import Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes


_DIRECTIONS = {"west to east": "#ff2d95", "south to north": "#ff8c00"}


_HEIGHTS = 12
"""Heights in the legend at most."""


def path_plot(scene: Scene, reach: Any, crosser: str, format: str = "png") -> bytes:  # noqa: A002  # matplotlib's word
    """Return the plot of ways and of what is reached as the bytes of an image file, which carries the map's recipe.

    crosser: what gets across, in words
    """
    along_x, along_y = scene.field.extent
    figure = figure_of(14, 6 * along_y / along_x + 1, 3, 14)
    plan, heat = figure.subplots(1, 2, sharex=True, sharey=True)
    draw_plan(plan, scene)
    for (name, colour), crossing in zip(_DIRECTIONS.items(), (reach.west_east, reach.south_north), strict=True):
        _draw_path(plan, scene, crossing, name, colour)
    figure.legend(loc="outside lower center", ncols=2, frameon=False)
    figure.legend(handles=legend_swatches(scene, _HEIGHTS), loc="outside left center", frameon=False)
    _draw_costs(heat, scene, reach)
    figure.suptitle(f"{scene.name}: {crosser}")
    return figure_bytes(figure, scene, format)


def _draw_path(axes: Axes, scene: Scene, crossing: Any, name: str, colour: str) -> None:
    """Draw a way from a ring to a dot; without one the legend says so, and a cross is where the robot got."""
    if not crossing.crosses:
        reason, place = getattr(crossing, "reason", None), getattr(crossing, "at", None)  # of a robot alone
        at = np.array([place]) if place else np.empty((0, 2))
        axes.plot(
            *at.T,
            "X",
            color=colour,
            markersize=11,
            markeredgecolor="white",
            label=f"no way from {name}{f': it {reason}' if reason else ''}",
        )
        return
    if hasattr(crossing, "points"):
        (x, y), rises = crossing.points.T, ""
    else:
        x, y = ((crossing.path + 0.5 - np.array(scene.field.shape) / 2) * scene.field.block_width).T
        rises = f", {crossing.cost_ratio:.2f} with its rises"
    # A pale wide line below keeps the way apart from blocks of its colour.
    label = f"{name}: {crossing.length_ratio:.2f} times as long as straight{rises}"
    axes.plot(x, y, color="white", linewidth=8, alpha=0.35, solid_joinstyle="round")
    axes.plot(x, y, color=colour, linewidth=4, alpha=0.75, solid_joinstyle="round", label=label)
    axes.plot(x[:1], y[:1], "o", color=colour, markersize=9, markerfacecolor="white", markeredgewidth=2)
    axes.plot(x[-1:], y[-1:], "o", color=colour, markersize=9, markeredgecolor="white")


def _draw_costs(axes: Axes, scene: Scene, reach: Any) -> None:
    """Draw what is reached: by limits of steps the cost from the west to each cell; and the outline of the area."""
    from matplotlib.collections import LineCollection

    show_cells(axes, scene.field, np.full((1, 1, 3), GROUND_GREY))
    outlined = f"outlined: {reach.coverage:.0%} of the blocks in one region"
    if not hasattr(reach.west_east, "costs"):
        shown = np.ma.masked_array(np.ones(reach.region.shape), ~reach.region)
        show_cells(axes, scene.field, shown, cmap=ramp(), vmin=0, vmax=4)
        axes.set(aspect="equal", xlabel="x [m]", title=outlined)
    else:
        costs = np.ma.masked_invalid(reach.west_east.costs)
        if costs.count():
            image = show_cells(axes, scene.field, costs, cmap=ramp())
            axes.figure.colorbar(image, ax=axes, shrink=0.8, label="cost of the way there [m]; grey: none")
        axes.set(aspect="equal", xlabel="x [m]", title=f"in reach from the west; {outlined}")
    lines = boundary(reach.region, *scene.field.edges())
    width = float(np.clip(200 / max(reach.region.shape), 0.1, 2.5))
    axes.add_collection(LineCollection(list(lines), colors="black", linewidths=width))
