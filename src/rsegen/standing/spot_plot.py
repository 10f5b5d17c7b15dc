"""A picture of spots: the plan of a map with the outline of a robot at each."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, sin
from typing import TYPE_CHECKING

import numpy as np

from rsegen.params.numbers import lengths_in
from rsegen.pictures.plan import draw_plan
from rsegen.pictures.preview import figure_bytes, figure_of
from rsegen.scene.scene import Scene
from rsegen.standing.spots import Outline, Spot

if TYPE_CHECKING:
    from matplotlib.axes import Axes

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
    figure.suptitle(
        f"{scene.name}: spots for {written.measured(outline.length, 1)} x {written.with_unit(outline.width, 1)}"
    )
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
