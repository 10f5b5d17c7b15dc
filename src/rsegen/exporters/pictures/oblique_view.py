"""A 3D view of a field from the south-east and above, by parallel projection.

The view is exact: columns on a grid are drawn from the farthest to the nearest, so that they hide one another as the
blocks do.
"""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from rsegen.exporters.pictures.plan import Drawable, cell_colours
from rsegen.field.coarse import coarse
from rsegen.field.stepfield import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

DRAWN = 200
"""Views of more cells per side are drawn coarser, each cell as the highest of several."""

_AZIMUTH, _ELEVATION = np.radians(-62), np.radians(38)
_LIT = {"top": 1.0, "x": 0.8, "y": 0.62}
_APART, _ARROW = 0.06, 0.25
"""How far the arrows along x and y are from the map, and how long, as shares of the mean side."""


def view_bounds(drawn: Drawable) -> Array:
    """The corners of the view in the plane of the picture, metres: [[left, low], [right, high]]."""
    (along_x, along_y), mean = drawn.field.extent, _mean_side(drawn)
    ends = ((-along_x / 2, along_x / 2), (-along_y / 2, along_y / 2), (0.0, float(drawn.field.heights.max())))
    x, y = (-along / 2 - _APART * mean for along in (along_x, along_y))
    label = 1.25 * _ARROW * mean
    arrows = [(x, y, 0.0), (x + label, y, 0.0), (x, y + label, 0.0)]
    points = _project(*np.array([*product(*ends), *arrows]).T)
    return np.stack([points.min(axis=0), points.max(axis=0)])


def draw_view(axes: Axes, drawn: Drawable) -> str:
    """Draw it, without a title; gives what the title should say."""
    from matplotlib.collections import PolyCollection

    factor = min(-(-max(drawn.field.shape) // DRAWN), *drawn.field.shape)
    field = coarse(drawn.field, factor)
    shapes, colours = _polygons(field.heights, cell_colours(drawn.surface_colour, field), field.block_width)
    line = 0.35 if max(field.shape) <= 60 else 0.0
    axes.add_collection(PolyCollection(list(shapes), facecolors=colours, edgecolors=colours * 0.55, linewidths=line))
    (left, low), (right, high) = view_bounds(drawn)
    axes.set(xlim=(left, right), ylim=(low, high), aspect="equal", anchor="C")
    axes.set_axis_off()
    _draw_axes(axes, drawn)
    return "seen from the south-east" + (f" (each column the highest of {factor} x {factor})" if factor > 1 else "")


def _polygons(heights: Array, colours: Array, width: float) -> tuple[Array, Array]:
    """Tops and the two visible sides of every column, the farthest first: (m, 4, 2) in the picture, (m, 3) colours."""
    n_x, n_y = heights.shape
    padded = np.pad(heights, 1)
    i, j = (np.ravel(index) for index in np.meshgrid(np.arange(n_x), np.arange(n_y)[::-1], indexing="ij"))
    x0, y0 = (i - n_x / 2) * width, (j - n_y / 2) * width
    x1, y1, top = x0 + width, y0 + width, heights[i, j]
    east, south = (np.minimum(top, beside) for beside in (padded[i + 2, j + 1], padded[i + 1, j]))
    faces = {
        "top": ((x0, y0, top), (x1, y0, top), (x1, y1, top), (x0, y1, top)),
        "x": ((x1, y0, east), (x1, y1, east), (x1, y1, top), (x1, y0, top)),
        "y": ((x0, y0, south), (x1, y0, south), (x1, y0, top), (x0, y0, top)),
    }
    shapes = np.stack([np.stack([_project(*corner) for corner in corners], axis=1) for corners in faces.values()], 1)
    lit = np.stack([_level_ground_is_grey(colours[i, j], top) * _LIT[face] for face in faces], axis=1)
    seen = np.stack([np.ones(len(i), dtype=bool), east < top, south < top], axis=1)
    return shapes[seen], lit[seen]


def _level_ground_is_grey(colours: Array, top: Array) -> Array:
    return np.where(top[:, None] > 0, colours, 0.86)


def _project(x: Array, y: Array, z: Array) -> Array:
    """Points in the plane of the picture, by parallel projection."""
    across = -x * np.sin(_AZIMUTH) + y * np.cos(_AZIMUTH)
    away = -x * np.cos(_AZIMUTH) - y * np.sin(_AZIMUTH)
    return np.stack([across, z * np.cos(_ELEVATION) + away * np.sin(_ELEVATION)], axis=-1)


def _draw_axes(axes: Axes, drawn: Drawable) -> None:
    """Draw arrows along x and y, from the corner of smallest x and y."""
    mean = _mean_side(drawn)
    start = np.array([-side / 2 - _APART * mean for side in drawn.field.extent])
    for name, along in (("x", (1, 0)), ("y", (0, 1))):
        end = start + _ARROW * mean * np.array(along)
        points = _project(*np.array([[*start, 0], [*end, 0]]).T)
        text = axes.annotate(name, xy=points[0], xytext=points[1], arrowprops={"arrowstyle": "<-"})
        text.set(ha="center", va="center", annotation_clip=False)


def _mean_side(drawn: Drawable) -> float:
    """The side of a square of the area of a map, metres."""
    along_x, along_y = drawn.field.extent
    return float(np.sqrt(along_x * along_y))
