"""Pictures of a robot on a map: its ways with a map of where it gets, and spots where it stands level."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, sin
from typing import TYPE_CHECKING

import numpy as np

from rsegen.exporters.numbers import lengths_in
from rsegen.exporters.pictures.plan import GROUND_GREY, boundary, draw_plan, show_cells
from rsegen.exporters.pictures.preview import figure_bytes, figure_of
from rsegen.exporters.scene import Scene
from rsegen.field.metrics import Crossing, StepLimits, Traversability
from rsegen.standing.spots import Outline, Spot
from rsegen.standing.ways import Reach, Way

if TYPE_CHECKING:
    from matplotlib.axes import Axes


_DIRECTIONS = {"west to east": "#ff2d95", "south to north": "#ff8c00"}


def path_plot(scene: Scene, reach: Traversability | Reach, crosser: str, format: str = "png") -> bytes:  # noqa: A002  # matplotlib's word
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
    _draw_costs(heat, scene, reach)
    figure.suptitle(f"{scene.name}: {crosser}")
    return figure_bytes(figure, scene, format)


def describe_limits(limits: StepLimits, units: str = "cm") -> str:
    """Describe limits of steps in words; units: of lengths, as in recipes."""
    written = lengths_in(units)
    up, down = (f"{written.short(limit)} {written.unit}" for limit in limits.limits)
    wide = f", {written.said(limits.width, 3)} wide" if limits.width_cm else ""
    return f"a path of steps of up to {up} up and {down} down{wide}"


def _draw_path(axes: Axes, scene: Scene, crossing: Crossing | Way, name: str, colour: str) -> None:
    """Draw a way from a ring to a dot; if there is none, the legend says so, and a cross stands where it ends."""
    if not crossing.crosses:
        reason = f": it {crossing.reason}" if isinstance(crossing, Way) and crossing.reason else ""
        at = np.array([crossing.at]) if isinstance(crossing, Way) and crossing.at else np.empty((0, 2))
        axes.plot(*at.T, "X", color=colour, markersize=11, markeredgecolor="white", label=f"no way from {name}{reason}")
        return
    if isinstance(crossing, Way):
        (x, y), rises = crossing.points.T, ""
    else:
        x, y = ((crossing.path + 0.5 - np.array(scene.field.shape) / 2) * scene.field.block_width).T
        rises = f", {crossing.cost_ratio:.2f} with its rises"
    label = f"{name}: {crossing.length_ratio:.2f} times as long as straight{rises}"
    axes.plot(x, y, color="white", linewidth=8, alpha=0.35, solid_joinstyle="round")
    axes.plot(x, y, color=colour, linewidth=4, alpha=0.75, solid_joinstyle="round", label=label)
    axes.plot(x[:1], y[:1], "o", color=colour, markersize=9, markerfacecolor="white", markeredgewidth=2)
    axes.plot(x[-1:], y[-1:], "o", color=colour, markersize=9, markeredgecolor="white")


def _draw_costs(axes: Axes, scene: Scene, reach: Traversability | Reach) -> None:
    """Draw what is reached: by limits of steps the cost from the west to each cell; and the outline of the area."""
    from matplotlib.collections import LineCollection

    show_cells(axes, scene.field, np.full((1, 1, 3), GROUND_GREY))
    outlined = f"outlined: {reach.cover:.0%} of the blocks in one region"
    if isinstance(reach, Reach):
        shown = np.ma.masked_array(np.ones(reach.region.shape), ~reach.region)
        show_cells(axes, scene.field, shown, cmap="summer", vmin=0, vmax=2)
        axes.set(aspect="equal", xlabel="x [m]", title=outlined)
    else:
        costs = np.ma.masked_invalid(reach.west_east.costs)
        if costs.count():
            image = show_cells(axes, scene.field, costs, cmap="viridis")
            axes.figure.colorbar(image, ax=axes, shrink=0.8, label="cost of the way there [m]; grey: none")
        axes.set(aspect="equal", xlabel="x [m]", title=f"in reach from the west; {outlined}")
    lines = boundary(reach.region, *scene.field.edges())
    width = float(np.clip(200 / max(reach.region.shape), 0.1, 2.5))
    axes.add_collection(LineCollection(list(lines), colors="#ff2d95", linewidths=width))


_COLOUR = "#ff2d95"
"""Colour of robots, which no level has."""


def spots_plot(scene: Scene, outline: Outline, spots: Sequence[Spot], format: str = "png") -> bytes:  # noqa: A002  # matplotlib's word
    """Return the spots on the plan as the bytes of an image file with the map's recipe; outline: around the robot."""
    along_x, along_y = scene.field.extent
    figure = figure_of(9, 8 * along_y / along_x + 1, 3, 16)
    axes = figure.subplots()
    draw_plan(axes, scene)
    for index, spot in enumerate(spots):
        _draw_spot(axes, outline, spot, str(index))
    written = lengths_in(scene.units)
    figure.suptitle(f"{scene.name}: spots for {written.measured(outline.length, 1)} x {written.said(outline.width, 1)}")
    return figure_bytes(figure, scene, format)


def _draw_spot(axes: Axes, outline: Outline, spot: Spot, text: str) -> None:
    """Draw the outline, a text at its rear half, and an arrow from its middle to its front."""
    corners, (middle_x, middle_y) = outline.at(spot), outline.middle
    axes.fill(*corners.T, facecolor=_COLOUR, alpha=0.35)
    axes.plot(*np.concatenate([corners, corners[:1]]).T, color=_COLOUR, linewidth=1.5)
    # From the frame of the robot into that of the map.
    c, s = cos(spot.yaw), sin(spot.yaw)
    points = [(middle_x, middle_y), (outline.high_x, middle_y), (outline.low_x + outline.length / 4, middle_y)]
    tail, head, name = ((spot.x + c * x - s * y, spot.y + s * x + c * y) for x, y in points)
    arrow = {"arrowstyle": "-|>", "color": "black", "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", xy=head, xytext=tail, arrowprops=arrow)
    label = {"facecolor": "white", "edgecolor": "none", "pad": 1}
    axes.text(*name, text, ha="center", va="center", fontsize=8, bbox=label)
