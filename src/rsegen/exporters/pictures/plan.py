"""The plan of a field, north up, with the heights in its cells if they fit."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol

import numpy as np

from rsegen.exporters.numbers import decimal
from rsegen.exporters.scene import Colour
from rsegen.field.stepfield import Array, StepField

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LEGIBLE = 26
"""Plans of up to this many cells per side have the heights in their cells."""


class Drawable(Protocol):
    """A field, and the colour of each of its materials: a scene, or a field by itself."""

    @property
    def field(self) -> StepField:
        """The blocks and frames to draw."""

    def colour(self, material: int) -> Colour:
        """The colour of a material: 0 is the frame, any other number a level."""

    def surface_colour(self, material: int) -> Colour:
        """The colour that its surface has from afar, in views."""


def draw_plan(axes: Axes, drawn: Drawable) -> None:
    """Draw a field from above, north up, with the heights in centimetres if they fit into the cells."""
    axes.set(xlabel="x [m]", ylabel="y [m]", title=draw_heights(axes, drawn))


def draw_heights(axes: Axes, drawn: Drawable) -> str:
    """Draw a field from above without a title; gives what the title should say."""
    colours = draw_cells(axes, drawn)
    if max(drawn.field.shape) > LEGIBLE:
        return "plan"
    _write_heights(axes, drawn, colours)
    return "plan, heights in cm"


def draw_cells(axes: Axes, drawn: Drawable) -> Array:
    """Draw the colours of a plan without heights, and return them: (n_x, n_y, 3)."""
    field = drawn.field
    edges_x, edges_y = field.edges()
    colours = cell_colours(drawn.colour, field)
    extent = (edges_x[0], edges_x[-1], edges_y[0], edges_y[-1])
    axes.imshow(colours.transpose(1, 0, 2), origin="lower", extent=extent, interpolation="nearest")
    return colours


def _write_heights(axes: Axes, drawn: Drawable, colours: Array) -> None:
    middle_x, middle_y = ((line[:-1] + line[1:]) / 2 for line in drawn.field.edges())
    size = min(11.0, 150 / max(drawn.field.shape))
    heights = drawn.field.heights
    for i, j in zip(*np.nonzero(~drawn.field.frame), strict=True):
        ink = "white" if colours[i, j] @ (0.3, 0.59, 0.11) < 0.5 else "black"
        text = decimal(round(heights[i, j] * 100, 4))
        axes.text(middle_x[i], middle_y[j], text, ha="center", va="center", fontsize=size, color=ink)


def number_cells(axes: Axes, field: StepField) -> None:
    """Count the cells of recipes, frames left out, below and on the left; metres are above and on the right."""
    from matplotlib.ticker import MaxNLocator

    for axis, (name, edges) in enumerate(zip("xy", field.edges(), strict=True)):
        middles = ((edges[:-1] + edges[1:]) / 2)[field.inside(axis)]
        inches = axes.get_window_extent().size[axis] / axes.figure.dpi
        step = next(step for step in _STEPS if step * inches / field.shape[axis] >= _APART)
        own = axes.yaxis if axis else axes.xaxis
        own.set_ticks(list(middles[::step]), [str(number) for number in range(0, len(middles), step)])
        own.set_label_text(f"{name} [cells]")
        metres = axes.secondary_yaxis("right") if axis else axes.secondary_xaxis("top")
        (metres.yaxis if axis else metres.xaxis).set_major_locator(
            MaxNLocator(max(2, int(inches / 0.7)), steps=[1, 2, 5, 10])
        )
        (metres.set_ylabel if axis else metres.set_xlabel)(f"{name} [m]")


_APART = 0.26
_STEPS = [factor * 10**power for power in range(6) for factor in (1, 2, 5)]
"""Every how many cells one is numbered: the least of these whose numbers are so many inches apart."""


def cell_colours(colour: Callable[[int], Colour], field: StepField) -> Array:
    """The colour of each cell of a field, or of a coarser one, (n_x, n_y, 3); level ground is light grey."""
    palette = np.array([colour(level) for level in range(int(field.levels.max()) + 1)])
    colours = palette[np.where(field.frame, 0, field.levels)]
    return np.where((field.levels == 0)[..., None] & ~field.frame[..., None], 0.86, colours)
