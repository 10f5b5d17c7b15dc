"""The preview of a map: a plan with its heights beside a 3D view; it needs no display.

The view is exact: columns on a grid are drawn from the farthest to the nearest, so that they hide one another as the
blocks do.
"""

from __future__ import annotations

import io
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from rsegen.errors import FileError
from rsegen.exporters.numbers import decimal
from rsegen.exporters.scene import Colour, Scene
from rsegen.field.coarse import coarse
from rsegen.field.stepfield import Array, StepField
from rsegen.recipe.codec import to_json

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FORMATS = ("png", "svg", "pdf", "jpg", "webp")
LEGIBLE = 26
"""Plans of up to this many cells per side have the heights in their cells."""
DRAWN = 200
"""Views of more cells per side are drawn coarser, each cell as the highest of several."""

_AZIMUTH, _ELEVATION = np.radians(-62), np.radians(38)
_LIT = {"top": 1.0, "x": 0.8, "y": 0.62}


class Drawable(Protocol):
    """A field, and the colour of each of its materials: a scene, or a field by itself."""

    @property
    def field(self) -> StepField:
        """The blocks and frames to draw."""

    def colour(self, material: int) -> Colour:
        """The colour of a material: 0 is the frame, any other number a level."""


def preview_image(scene: Scene, format: str = "png") -> bytes:  # noqa: A002  # matplotlib's word
    """The plan and the 3D view of a map as the bytes of an image file."""
    return figure_bytes(preview_figure(scene, _title(scene)), scene, format)


def preview_figure(drawn: Drawable, title: str) -> Figure:
    """The plan and the 3D view of a field side by side, with a legend of its heights."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(14, 6.6), dpi=100, layout="constrained")
    left, right = figure.subplots(1, 2)
    draw_plan(left, drawn)
    _draw_view(right, drawn)
    _draw_legend(figure, drawn)
    figure.suptitle(title)
    return figure


def figure_bytes(figure: Figure, scene: Scene, format: str) -> bytes:  # noqa: A002  # matplotlib's word
    """A figure about a map as the bytes of an image file, which carries the map's recipe."""
    return encoded(figure, format, _metadata(scene, format))


def encoded(figure: Figure, format: str, metadata: dict[str, Any] | None = None) -> bytes:  # noqa: A002  # the same
    """A figure as the bytes of an image file; the same figure gives the same bytes."""
    from matplotlib import rc_context

    stream = io.BytesIO()
    with rc_context({"svg.hashsalt": "rsegen"}):
        figure.savefig(stream, format=format, metadata=metadata)
    return stream.getvalue()


def pdf_bytes(figures: Iterable[Figure], scene: Scene) -> bytes:
    """Figures about a map as the pages of a PDF, which carries the map's recipe."""
    from matplotlib.backends.backend_pdf import PdfPages

    stream = io.BytesIO()
    with PdfPages(stream, metadata={"Title": scene.name, **(_metadata(scene, "pdf") or {})}) as pages:
        for figure in figures:
            pages.savefig(figure)
    return stream.getvalue()


def image_format(path: Path) -> str:
    """The image format of a file name, or a FileError that lists the known ones."""
    name = path.suffix.lower().removeprefix(".").replace("jpeg", "jpg")
    if name not in FORMATS:
        raise FileError(f"{path}: not a picture's name; end it in one of .{', .'.join(FORMATS)}")
    return name


def draw_plan(axes: Axes, drawn: Drawable) -> None:
    """Draw a field from above, north up, with the heights in centimetres if they fit into the cells."""
    colours = draw_cells(axes, drawn)
    legible = max(drawn.field.shape) <= LEGIBLE
    axes.set(xlabel="x [m]", ylabel="y [m]", title="plan, heights in cm" if legible else "plan")
    if legible:
        _write_heights(axes, drawn, colours)


def draw_cells(axes: Axes, drawn: Drawable) -> Array:
    """Draw the colours of a plan without heights, and return them: (n_x, n_y, 3)."""
    field = drawn.field
    edges_x, edges_y = field.edges()
    colours = cell_colours(drawn, field)
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


def _draw_view(axes: Axes, drawn: Drawable) -> None:
    """Draw the 3D view from the south-east and above."""
    from matplotlib.collections import PolyCollection

    factor = min(-(-max(drawn.field.shape) // DRAWN), *drawn.field.shape)
    field = coarse(drawn.field, factor)
    shapes, colours = _polygons(field.heights, cell_colours(drawn, field), field.block_width)
    line = 0.35 if max(field.shape) <= 60 else 0.0
    axes.add_collection(PolyCollection(list(shapes), facecolors=colours, edgecolors=colours * 0.55, linewidths=line))
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.set_axis_off()
    how = f" (each column the highest of {factor} x {factor} cells)" if factor > 1 else ""
    axes.set_title(f"seen from the south-east{how}")
    _draw_axes(axes, drawn)


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
    corner = np.array([-side / 2 for side in drawn.field.extent])
    length = max(drawn.field.extent) / 4
    for name, along in (("x", (1, 0)), ("y", (0, 1))):
        start = corner - 0.06 * np.array(drawn.field.extent)
        end = start + length * np.array(along)
        points = _project(*np.array([[*start, 0], [*end, 0]]).T)
        text = axes.annotate(name, xy=points[0], xytext=points[1], arrowprops={"arrowstyle": "<-"})
        text.set(ha="center", va="center", annotation_clip=False)


def _draw_legend(figure: Figure, drawn: Drawable) -> None:
    """Draw a swatch for every height that the map has, up to 24 of them."""
    from matplotlib.patches import Patch

    levels = [level for level in drawn.field.level_counts() if level]
    shown = levels[:: -(-len(levels) // 24) or 1]
    unit = drawn.field.unit * 100
    swatches = [Patch(facecolor=drawn.colour(level), label=f"{decimal(level * unit)} cm") for level in shown]
    if drawn.field.frame.any():
        frame = decimal(drawn.field.frame_height * 100)
        swatches.append(Patch(facecolor=drawn.colour(0), label=f"frame, {frame} cm"))
    if swatches:
        figure.legend(handles=swatches, loc="outside right center", frameon=False)


def _title(scene: Scene) -> str:
    n_x, n_y = scene.field.shape
    along_x, along_y = map(decimal, scene.field.extent)
    return f"{scene.name}: {n_x} x {n_y} cells, {along_x} x {along_y} m, seed {scene.recipe.seed}"


def cell_colours(drawn: Drawable, field: StepField) -> Array:
    """The colour of each cell of a field, or of a coarser one, (n_x, n_y, 3); level ground is light grey."""
    palette = np.array([drawn.colour(level) for level in range(int(field.levels.max()) + 1)])
    colours = palette[np.where(field.frame, 0, field.levels)]
    return np.where((field.levels == 0)[..., None] & ~field.frame[..., None], 0.86, colours)


def _metadata(scene: Scene, format: str) -> dict[str, Any] | None:  # noqa: A002  # matplotlib's word
    """The recipe of the map, if the format has a place for it, and no date: the same map gives the same bytes."""
    recipe = to_json(scene.alone)
    known: dict[str, dict[str, Any]] = {
        "png": {"Description": recipe},
        "svg": {"Description": recipe, "Date": None},
        "pdf": {"Subject": recipe, "CreationDate": None},
    }
    return known.get(format)
