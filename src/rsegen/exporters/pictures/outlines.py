"""The outlines of a map's obstacles on its plan, numbered from 0 as messages number them: obstacles[0], ..."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rsegen.exporters.scene import Scene
from rsegen.field.stepfield import Array, Ints, Mask
from rsegen.recipe.building import placed
from rsegen.recipe.placement import Placement

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_COLOURS = ("#ff2d95", "#ff8c00", "#7b2ff7", "#00a3ff", "#111111", "#b8002e")


def draw_outlines(axes: Axes, scene: Scene) -> list[tuple[str, str]]:
    """Draw around the cells of each obstacle; gives what the legend should say: colour, number and kind."""
    from matplotlib.collections import LineCollection

    edges = scene.field.edges()
    width = float(np.clip(120 / max(scene.field.shape), 0.8, 3))
    shown = []
    for number, placement in enumerate(scene.recipe.obstacles):
        colour = _COLOURS[number % len(_COLOURS)]
        cells = covered(scene, placement)
        lines = boundary(cells, *edges)
        for line, drawn in ((width + 1.6, "white"), (width, colour)):
            axes.add_collection(LineCollection(list(lines), colors=drawn, linewidths=line, capstyle="projecting"))
        if cells.any():
            _write_number(axes, cells, edges, str(number), colour)
        shown.append((colour, f"{number}  {placement.obstacle.kind}"))
    return shown


def covered(scene: Scene, placement: Placement) -> Mask:
    """The cells that an obstacle covers, with the frames between them, (n_x, n_y); later ones may replace it there."""
    _, _, patch = placed(scene.recipe, placement, scene.index)
    found = np.zeros(scene.field.shape, dtype=bool)
    i, j = (np.flatnonzero(scene.field.inside(axis))[patch.window[axis]] for axis in (0, 1))
    found[np.ix_(i, j)] = patch.footprint
    for axis, lines in enumerate((i, j)):
        between = np.setdiff1d(np.arange(lines.min(), lines.max()), lines)
        before, after = (np.take(found, _nearest(lines, between, side), axis) for side in (-1, 1))
        found[(slice(None),) * axis + (between,)] = before & after
    return found


def _nearest(lines: Ints, between: Ints, side: int) -> Ints:
    """Of lines between others, which are sorted, the nearest of the others before or after each."""
    at = np.searchsorted(lines, between)
    return lines[at if side > 0 else at - 1]


def boundary(cells: Mask, edges_x: Array, edges_y: Array) -> Array:
    """The sides of cells beyond which there are others, as lines: metres, (m, 2, 2)."""
    region = np.pad(cells, 1)
    i, j = np.nonzero(region[1:, 1:-1] != region[:-1, 1:-1])
    upright = np.stack([np.stack([edges_x[i], edges_y[j + side]], axis=-1) for side in (0, 1)], axis=1)
    i, j = np.nonzero(region[1:-1, 1:] != region[1:-1, :-1])
    level = np.stack([np.stack([edges_x[i + side], edges_y[j]], axis=-1) for side in (0, 1)], axis=1)
    return np.concatenate([upright, level])


def _write_number(axes: Axes, cells: Mask, edges: tuple[Array, Array], text: str, colour: str) -> None:
    """Write a number on the covered cell that is the leftmost of the highest row."""
    j = int(np.flatnonzero(cells.any(axis=0))[-1])
    i = int(np.flatnonzero(cells[:, j])[0])
    x, y = edges[0][i], edges[1][j + 1]
    box = {"facecolor": colour, "edgecolor": "white", "boxstyle": "round,pad=0.25"}
    axes.text(x, y, text, ha="center", va="center", fontsize=9, color="white", fontweight="bold", bbox=box, zorder=5)
