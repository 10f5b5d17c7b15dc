"""The plan of a field, north up: colours of cells, heights if they fit, outlines of the obstacles of a map.

Obstacles are numbered from 0, as in messages: obstacles[0], ...
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from rsegen.field.stepfield import Array, Ints, Mask, StepField
from rsegen.obstacles import Obstacle
from rsegen.params.numbers import lengths_in
from rsegen.recipe.building import placed
from rsegen.scene.colours import Colour, height_colour
from rsegen.scene.scene import FRAME_COLOUR, Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap
    from matplotlib.image import AxesImage


LEGIBLE = 26
"""Cells per side up to which a plan has the heights in its cells: the font is then 5.8 points."""


_SMALLEST = 4.0
"""Points of the smallest heights in cells that print."""


GROUND_GREY = 0.86
"""Grey of level ground, 0..1: lighter than all levels, darker than paper."""


@dataclass(frozen=True, kw_only=True, slots=True)
class ColouredField:
    """A field with the default colours: frames red, blocks in the colours of their heights."""

    field: StepField
    units: str = "cm"

    def plan_colour(self, material: int) -> Colour:
        """Return the colour of a material: 0 is the frame, any other number a level."""
        highest = int(self.field.levels.max(initial=0))
        return height_colour(material * self.field.unit, highest * self.field.unit) if material else FRAME_COLOUR

    view_colour = surface_colour = plan_colour


Drawable = Scene | ColouredField
"""A field, and the colour of each of its materials in plans, in views, and of its surface from afar."""


def draw_plan(axes: Axes, drawn: Drawable) -> None:
    """Draw a field from above, north up, with the heights in its units if they fit into the cells."""
    axes.set(xlabel="x [m]", ylabel="y [m]", title=draw_heights(axes, drawn))


def draw_heights(axes: Axes, drawn: Drawable, share: float = 1.0) -> str:
    """Draw a field from above without a title; return what the title should say.

    share: size of the letters in cells, as a share of the usual one
    """
    colours = draw_cells(axes, drawn)
    most = max(drawn.field.shape)
    size = min(11.0, 150 / most) * share  # the font shrinks with the cells
    if most > LEGIBLE or size < _SMALLEST:
        return "plan"
    written = lengths_in(drawn.units)
    middle_x, middle_y = drawn.field.middles()
    heights = drawn.field.heights
    for i, j in zip(*np.nonzero(~drawn.field.frame), strict=True):
        text, ink = written.measured(heights[i, j], 3), ink_on(colours[i, j])
        axes.text(middle_x[i], middle_y[j], text, ha="center", va="center", fontsize=size, color=ink)
    return f"plan, heights in {written.name}"


def ink_on(colour: Colour | Array) -> str:
    """Return the text colour that is legible on a colour, in greyscale print too (luma of ITU-R BT.601)."""
    red, green, blue = colour
    return "white" if 0.3 * red + 0.59 * green + 0.11 * blue < 0.5 else "black"


def draw_cells(axes: Axes, drawn: Drawable) -> Array:
    """Draw the colours of a plan without heights, and return them: (n_x, n_y, 3)."""
    colours = cell_colours(drawn.plan_colour, drawn.field)
    show_cells(axes, drawn.field, colours)
    return colours


def show_cells(axes: Axes, field: StepField, values: Array | Ints, **style: Any) -> AxesImage:
    """Draw a value per cell, (n_x, n_y), or a colour, (n_x, n_y, 3), where the cells of a field are, metres."""
    (west, *_, east), (south, *_, north) = (line.tolist() for line in field.edges())
    shown = values.transpose(1, 0, *range(2, values.ndim))
    style = {"origin": "lower", "extent": (west, east, south, north), "interpolation": "nearest", **style}
    return axes.imshow(shown, **style)


_CALM_TO_ALARMING = ((252, 240, 248), (240, 186, 222), (222, 120, 190), (172, 52, 152), (96, 8, 92))
"""The ramp of the page (overlay.ts), of evenly falling lightness, so that it differs in grey; no height has its hue."""


def ramp(*, reverse: bool = False) -> Colormap:
    """Return the colours of values that are no heights, such as tilt: from pale, which is calm, to dark purple.

    reverse: from dark to pale, for values of which high ones are calm
    """
    from matplotlib.colors import LinearSegmentedColormap

    colours = [tuple(part / 255 for part in colour) for colour in _CALM_TO_ALARMING]
    return LinearSegmentedColormap.from_list("calm to alarming", colours[::-1] if reverse else colours)


def number_cells(axes: Axes, field: StepField) -> None:
    """Count the cells of recipes, frames left out, below and on the left; metres are above and on the right."""
    from matplotlib.ticker import MaxNLocator

    for axis, (name, every) in enumerate(zip("xy", field.middles(), strict=True)):
        middles = every[field.inside(axis)]
        inches = axes.get_window_extent().size[axis] / axes.figure.dpi
        step = next(step for step in _STEPS if step * inches / field.shape[axis] >= _APART)
        own = axes.yaxis if axis else axes.xaxis
        own.set_ticks(list(middles[::step]), [str(cell) for cell in range(0, len(middles), step)])
        own.set_label_text(f"{name} [cells]")
        metres = axes.secondary_yaxis("right") if axis else axes.secondary_xaxis("top")
        fewest = 2 if inches >= 3 * _APART else 1
        locator = MaxNLocator(max(fewest, int(inches / 0.7)), steps=[1, 2, 5, 10], min_n_ticks=fewest)
        (metres.yaxis if axis else metres.xaxis).set_major_locator(locator)
        (metres.set_ylabel if axis else metres.set_xlabel)(f"{name} [m]")


_APART = 0.26
"""Inches between the numbers of cells, at the least: three digits of 10 points."""

_STEPS = [factor * 10**power for power in range(6) for factor in (1, 2, 5)]
"""Steps between the cells that are numbered, of which the least that leaves _APART is taken."""


def cell_colours(colour: Callable[[int], Colour], field: StepField) -> Array:
    """Return the colour of each cell of a field, (n_x, n_y, 3); level ground is light grey."""
    palette = np.array([colour(level) for level in range(int(field.levels.max()) + 1)])
    colours = palette[np.where(field.frame, 0, field.levels)]
    return np.where((field.levels == 0)[..., None] & ~field.frame[..., None], GROUND_GREY, colours)


def _swatches(drawn: Drawable, levels: Sequence[int], most: int) -> list[Any]:
    """Return a swatch for each level with its height; of more than `most` for every second, third, ..."""
    from matplotlib.patches import Patch

    unit, written = drawn.field.unit, lengths_in(drawn.units)
    shown = levels[:: -(-len(levels) // most) or 1]
    return [Patch(facecolor=drawn.plan_colour(level), label=written.with_unit(level * unit, 3)) for level in shown]


def legend_swatches(drawn: Drawable, most: int, levels: Collection[int] | None = None) -> list[Any]:
    """Return swatches of all that a plan shows: the level ground, at most `most` heights above it, and frames.

    levels: of several plans; by default of this one
    """
    from matplotlib.patches import Patch

    field, written = drawn.field, lengths_in(drawn.units)
    levels = field.level_counts() if levels is None else levels
    entries = _swatches(drawn, sorted(level for level in levels if level), most)
    if 0 in levels:
        entries.insert(0, Patch(facecolor=f"{GROUND_GREY}", label=written.with_unit(0, 3)))
    if field.frame.any():
        frame = written.with_unit(field.frame_height, 3)
        entries.append(Patch(facecolor=drawn.plan_colour(0), label=f"frame, {frame}"))
    return entries


_COLOURS = ("#ff2d95", "#ff8c00", "#7b2ff7", "#00a3ff", "#111111", "#b8002e")
"""Colours of outlines, none of which is the colour of a level; the seventh obstacle has the first one again."""


def draw_outlines(axes: Axes, scene: Scene) -> list[tuple[str, str]]:
    """Draw around the cells of each obstacle; return what the legend should say: colour, number and kind."""
    from matplotlib.collections import LineCollection

    edges = scene.field.edges()
    width = float(np.clip(120 / max(scene.field.shape), 0.8, 3))
    shown = []
    for index, obstacle in scene.recipe.enabled_obstacles:
        colour = _COLOURS[index % len(_COLOURS)]
        cells = covered_cells(scene, obstacle)
        lines = boundary(cells, *edges)
        for line, drawn in ((width + 1.6, "white"), (width, colour)):
            axes.add_collection(LineCollection(list(lines), colors=drawn, linewidths=line, capstyle="projecting"))
        if cells.any():
            # Its number is on the covered cell that is the leftmost of the highest row.
            j = int(np.flatnonzero(cells.any(axis=0))[-1])
            x, y = edges[0][np.flatnonzero(cells[:, j])[0]], edges[1][j + 1]
            style: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": 9, "fontweight": "bold", "zorder": 5}
            box = {"facecolor": colour, "edgecolor": "white", "boxstyle": "round,pad=0.25"}
            axes.text(x, y, str(index), color="white", bbox=box, **style)
        shown.append((colour, f"{index}  {obstacle.kind}"))
    return shown


def covered_cells(scene: Scene, obstacle: Obstacle) -> Mask:
    """Return the cells that an obstacle covers at first, with frames between them, (n_x, n_y)."""
    _, _, patch = placed(scene.recipe, obstacle, scene.index)
    cells = np.zeros(scene.field.shape, dtype=bool)
    i, j = (np.flatnonzero(scene.field.inside(axis))[patch.window[axis]] for axis in (0, 1))
    cells[np.ix_(i, j)] = patch.footprint
    for axis, lines in enumerate((i, j)):
        between = np.setdiff1d(np.arange(lines.min(), lines.max()), lines)
        # Frame lines between covered ones have what the nearest of these before and after them both have.
        at = np.searchsorted(lines, between)
        before, after = (np.take(cells, lines[nearest], axis) for nearest in (at - 1, at))
        cells[(slice(None),) * axis + (between,)] = before & after
    return cells


def boundary(cells: Mask, edges_x: Array, edges_y: Array) -> Array:
    """Return the sides between cells of a mask and cells outside it, as lines: metres, (m, 2, 2)."""
    return changes(np.pad(cells, 1), edges_x, edges_y)


def changes(region: Array | Mask, edges_x: Array, edges_y: Array) -> Array:
    """Return the sides between cells of different values, as lines; region: the cells, and one more on each side."""
    i, j = np.nonzero(region[1:, 1:-1] != region[:-1, 1:-1])
    upright = np.stack([np.stack([edges_x[i], edges_y[j + side]], axis=-1) for side in (0, 1)], axis=1)
    i, j = np.nonzero(region[1:-1, 1:] != region[1:-1, :-1])
    level = np.stack([np.stack([edges_x[i + side], edges_y[j]], axis=-1) for side in (0, 1)], axis=1)
    return np.concatenate([upright, level])
