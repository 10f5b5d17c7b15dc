"""Pictures of poses: maps of how a robot of one heading rests at each place, and its outlines at spots on the plan.

A pixel of a map is a pose, a quarter of a block from the next.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, degrees, sin
from typing import TYPE_CHECKING

import numpy as np

from rsegen.field.stepfield import Array, Ints, StepField
from rsegen.params.numbers import lengths_in
from rsegen.pictures.plan import changes, draw_plan, ramp, show_cells
from rsegen.pictures.preview import figure_bytes, figure_of
from rsegen.scene.scene import Scene
from rsegen.standing.body import Body
from rsegen.standing.drawing import draw_robot
from rsegen.standing.outlines import Outline, Spot
from rsegen.standing.resting import REASONS, resting_poses
from rsegen.standing.settling import outer_radius

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap

_PER_BLOCK, _MOST = 4, 240
"""Poses along the side of a block, and along the longer side of a map at most: 60,000 take some ten seconds."""

_NAMES = ("stands and pushes", *REASONS[1:])
_REASON_COLOURS = ("#4caf78", "#f2c14e", "#e8743b", "#8e2043")
"""Colours from good to bad, darker for worse, so that they differ in grey too."""

_MOST_MARGIN = 45.0
"""Degrees at which the colours of margins end: all safer places look alike."""

_SPOT_COLOUR = "#ff2d95"
"""Colour of robots at spots, which no level has."""


def pose_maps(scene: Scene, body: Body, heading: float, format: str = "png", *, robot: str = "robot") -> bytes:  # noqa: A002  # matplotlib's word
    """Return maps of tilt, margin and reason as the bytes of an image file, which carries the map's recipe.

    heading: radians; robot: its name in the title. The margin is the angle by which it must be turned to tip over.
    """
    x, y = _places(scene.field)
    rests = resting_poses(scene.field, body, x[:, None], y[None, :], np.array(heading))
    along_x, along_y = scene.field.extent
    figure = figure_of(15, 3.9 * along_y / along_x + 1.7, 3.2, 16)
    tilt, margin, reason = figure.subplots(1, 3, sharex=True, sharey=True)
    tilts, margins = (np.degrees(np.where(rests.stands, angle, np.nan)) for angle in (rests.tilt, rests.tip_angle))
    shape = (len(x), len(y))
    _draw_angles(tilt, scene.field, tilts.reshape(shape), "tilt", ramp())
    _draw_angles(margin, scene.field, margins.reshape(shape), "margin", ramp(reverse=True), _MOST_MARGIN)
    _draw_reasons(reason, scene.field, rests.reason.reshape(shape))
    # The robot is drawn where it is steepest of all places at which it is on the map.
    radius, drawn = outer_radius(body), ""
    inside = (np.abs(rests.x) < along_x / 2 - radius) & (np.abs(rests.y) < along_y / 2 - radius)
    if (rests.stands & inside).any():
        draw_robot(tilt, body, rests, int(np.where(rests.stands & inside, rests.tilt, -1).argmax()))
        drawn = "; drawn: the robot where it is steepest"
    tilt.set(ylabel="y [m]", title=f"tilt{drawn}")
    margin.set(title="margin: the turn that tips it over")
    figure.suptitle(f"{scene.name}: {robot}, heading {degrees(heading) % 360:.3g} degrees")
    return figure_bytes(figure, scene, format)


def _places(field: StepField) -> tuple[Array, Array]:
    """Return x and y of the poses, metres: the middles of half blocks, or of larger parts of a large map."""
    per_block = min(_PER_BLOCK, _MOST / max(field.shape))
    counts = (max(round(cells * per_block), 1) for cells in field.shape)
    x, y = (((np.arange(count) + 0.5) / count - 0.5) * side for count, side in zip(counts, field.extent, strict=True))
    return x, y


def _draw_angles(
    axes: Axes, field: StepField, angles: Array, label: str, colours: Colormap, most: float | None = None
) -> None:
    """Draw a map of angles in degrees; grey where the robot does not stand (NaN)."""
    axes.set_facecolor("0.6")
    image = show_cells(axes, field, angles, cmap=colours, vmin=0, vmax=most)
    extend = "max" if most else "neither"
    axes.figure.colorbar(image, ax=axes, shrink=0.85, extend=extend, label=f"{label} [degrees]; grey: tips over")
    _draw_blocks(axes, field)


def _draw_reasons(axes: Axes, field: StepField, reason: Ints) -> None:
    """Draw a map of reasons, whose legend has the share of each."""
    from matplotlib.colors import BoundaryNorm, ListedColormap
    from matplotlib.patches import Patch

    norm = BoundaryNorm(np.arange(len(_NAMES) + 1) - 0.5, len(_NAMES))
    colours = ListedColormap(_REASON_COLOURS)
    show_cells(axes, field, reason, cmap=colours, norm=norm)
    shares = [float((reason == index).mean()) for index in range(len(_NAMES))]
    entries = [
        Patch(facecolor=colour, label=f"{name}, {share:.0%}")
        for colour, name, share in zip(_REASON_COLOURS, _NAMES, shares, strict=True)
    ]
    axes.set(title="what it can do there")
    axes.figure.legend(handles=entries, loc="outside lower center", ncols=len(entries), frameon=False)
    _draw_blocks(axes, field)


def _draw_blocks(axes: Axes, field: StepField) -> None:
    """Draw the edges between blocks of different heights, and set the plan's axes."""
    from matplotlib.collections import LineCollection

    edges_x, edges_y = field.edges()
    lines = changes(np.pad(field.heights, 1, mode="edge"), edges_x, edges_y)
    width = float(np.clip(24 / max(field.shape), 0.1, 0.8))
    axes.add_collection(LineCollection(list(lines), colors="black", linewidths=width, alpha=0.45))
    axes.set(aspect="equal", xlabel="x [m]", xlim=edges_x[[0, -1]], ylim=edges_y[[0, -1]])


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
    axes.fill(*corners.T, facecolor=_SPOT_COLOUR, alpha=0.35)
    axes.plot(*np.concatenate([corners, corners[:1]]).T, color=_SPOT_COLOUR, linewidth=1.5)
    # From the frame of the robot into that of the map.
    c, s = cos(spot.yaw), sin(spot.yaw)
    points = [(middle_x, middle_y), (outline.high_x, middle_y), (outline.low_x + outline.length / 4, middle_y)]
    tail, head, name = ((spot.x + c * x - s * y, spot.y + s * x + c * y) for x, y in points)
    arrow = {"arrowstyle": "-|>", "color": "black", "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", xy=head, xytext=tail, arrowprops=arrow)
    label = {"facecolor": "white", "edgecolor": "none", "pad": 1}
    axes.text(*name, text, ha="center", va="center", fontsize=8, bbox=label)
