"""Spots as a picture: the footprints of a robot on the plan of a map, numbered, each with an arrow ahead."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, sin
from typing import TYPE_CHECKING

import numpy as np

from rsegen.exporters.pictures.plan import draw_plan
from rsegen.exporters.pictures.preview import figure_bytes
from rsegen.exporters.scene import Scene
from rsegen.field.spots import Rectangle, Spot
from rsegen.field.stepfield import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_COLOUR = "#ff2d95"


def spots_plot(scene: Scene, outline: Rectangle, spots: Sequence[Spot], format: str = "png") -> bytes:  # noqa: A002  # matplotlib's word
    """The picture as the bytes of an image file, which carries the map's recipe; outline: around the robot."""
    from matplotlib.figure import Figure

    along_x, along_y = scene.field.extent
    height = float(np.clip(8 * along_y / along_x + 1, 3, 16))
    figure = Figure(figsize=(9, height), dpi=100, layout="constrained")
    axes = figure.subplots()
    draw_plan(axes, scene)
    for number, spot in enumerate(spots):
        _draw_spot(axes, outline, spot, number)
    figure.suptitle(f"{scene.name}: spots for {outline.length * 100:.3g} x {outline.width * 100:.3g} cm")
    return figure_bytes(figure, scene, format)


def _draw_spot(axes: Axes, outline: Rectangle, spot: Spot, number: int) -> None:
    """Draw the outline, the number at its rear half, and an arrow from its middle to its front."""
    low_x, low_y, high_x, high_y = outline
    middle_x, middle_y = outline.middle
    corners = _placed(spot, [(low_x, low_y), (high_x, low_y), (high_x, high_y), (low_x, high_y)])
    axes.fill(*corners.T, facecolor=_COLOUR, alpha=0.35)
    axes.plot(*np.concatenate([corners, corners[:1]]).T, color=_COLOUR, linewidth=1.5)
    tail, head, name = _placed(spot, [(middle_x, middle_y), (high_x, middle_y), (low_x + outline.length / 4, middle_y)])
    axes.annotate(
        "", xy=head, xytext=tail, arrowprops={"arrowstyle": "-|>", "color": "black", "shrinkA": 0, "shrinkB": 0}
    )
    label = {"facecolor": "white", "edgecolor": "none", "pad": 1}
    axes.text(float(name[0]), float(name[1]), str(number), ha="center", va="center", fontsize=8, bbox=label)


def _placed(spot: Spot, points: Sequence[tuple[float, float]]) -> Array:
    """Points in the frame of a robot, where they are on the map, shape (n, 2)."""
    c, s = cos(spot.yaw), sin(spot.yaw)
    return np.array([(spot.x + c * x - s * y, spot.y + s * x + c * y) for x, y in points])
