"""The preview of a map: a plan with its heights and a 3D view; it needs no display.

The view is from the south-east and above, by parallel projection. It is exact: columns on a grid are drawn from the
farthest to the nearest (the painter's algorithm), so that they hide one another as the blocks do. Plan and view are
side by side, or one below the other for long maps. Nearly all time goes into drawing three polygons per column, so of
large maps each column is the highest of several cells.

     _______________________________       p = (-x sin a + y cos a,  z cos e + (-x cos a - y sin a) sin e)
    |  plan   |   view     | legend |      for the azimuth a and the elevation e
    |_________|____________|________|
"""

from __future__ import annotations

import io
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from rsegen import __version__
from rsegen.errors import FileError, UnknownName, refuse_other
from rsegen.field.stepfield import Array, Ints, Mask, StepField, coarse, coarseness
from rsegen.params.numbers import decimal
from rsegen.pictures.plan import (
    GROUND_GREY,
    ColouredField,
    Drawable,
    cell_colours,
    draw_heights,
    draw_outlines,
    legend_swatches,
    number_cells,
)
from rsegen.recipe.codec import to_json
from rsegen.scene.scene import Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


class DrawnRobot(Protocol):
    """A robot at rest at one place, as `rsegen.standing` has it."""

    def draw(self, plan: Axes) -> None:
        """Draw it on a plan."""

    def in_front(self, field: StepField) -> Mask:
        """Return which cells of a field are in front of it in the view, (n_x, n_y)."""

    def silhouettes(self, project: Callable[..., Array], toward: Array) -> Iterable[tuple[Array, str]]:
        """Return outline and colour of each part in a view, the farthest first."""

    def describe(self) -> str:
        """Return in words how it stands."""


class Drawn(Protocol):
    """An object that can be drawn at rest on a field: a robot."""

    def drawn_at(self, field: StepField, x: float, y: float, heading: float) -> DrawnRobot:
        """Return it where it settles."""


Box = tuple[float, float, float, float]
"""Left, low, width and height of a part of the picture; inches, or shares of the picture."""

WIDTH = 16.0
"""Width of a picture in inches, at the most: 1600 pixels."""

_TALLEST = 8.5
"""Height of a plan or view in inches, at the most, so that the picture of a tall map fits on a screen."""

_LONG = 2.0
"""Ratio of length to width from which the view is below the plan: next to it both would be low and small."""

_BESIDE, _BELOW, _ABOVE, _GAP, _EDGE = 0.7, 0.6, 0.8, 0.25, 0.12
"""Inches left and right of, below and above a plan for its numbers and title; between plan and view; at the edge."""

_TITLE, _HEAD = 0.35, 0.35
"""Inches of the title of the picture, and of the title of the view."""


@dataclass(frozen=True, kw_only=True, slots=True)
class PictureLayout:
    """Width and height of the picture in inches; the boxes of plan and view, and the left edge of the legend."""

    size: tuple[float, float]
    plan: Box
    view: Box
    legend: float

    def share(self, box: Box) -> Box:
        """Return a box as shares of the picture, as matplotlib takes it."""
        (wide, high), (left, low, width, height) = self.size, box
        return left / wide, low / high, width / wide, height / high


def layout(plan: float, view: float, legend: float) -> PictureLayout:
    """Return the layout for a plan and a view of some ratios of width to height and a legend of a width in inches."""
    if plan > _LONG:  # one below the other
        width = WIDTH - 2 * _BESIDE - legend - _EDGE
        below, above = min(width / view, _TALLEST), width / plan
        low = _EDGE + below + _HEAD + _BELOW
        return PictureLayout(
            size=(WIDTH, low + above + _ABOVE + _TITLE),
            plan=(_BESIDE, low, width, above),
            view=(_BESIDE, _EDGE, width, below),
            legend=WIDTH - legend,
        )
    # In a row; the view is higher than the plan, as it has no numbers above and below.
    more = _BELOW + _ABOVE - _HEAD - _EDGE
    free = WIDTH - 2 * _BESIDE - _GAP - legend - _EDGE
    height = min((free - more * view) / (plan + view), _TALLEST)
    left = _BESIDE + height * plan + _BESIDE + _GAP
    right = left + (height + more) * view + _EDGE
    return PictureLayout(
        size=(right + legend, _BELOW + height + _ABOVE + _TITLE),
        plan=(_BESIDE, _BELOW, height * plan, height),
        view=(left, _EDGE, (height + more) * view, height + more),
        legend=right,
    )


PAPER: dict[Any, Any] = {
    "font.size": 7,
    "axes.titlesize": 7,
    "axes.linewidth": 0.5,
    "legend.fontsize": 7,
    "pdf.fonttype": 42,
} | {f"{axis}tick.major.{key}": value for axis in "xy" for key, value in (("width", 0.5), ("size", 2), ("pad", 2))}
"""Settings of a picture for a paper: letters of 7 points, but in cells; fonts of a PDF as publishers want them."""

COLUMN, DPI, _TALL = 3.5, 300, 5.0
"""Inches of a column of a paper with two; pixels per inch; inches of a plan whose heights have their usual size."""


def _in_a_column(plan: float, view: float, entries: int, lines: int) -> PictureLayout:
    """Return the layout for a column of a paper: plan, view with a title of some lines, and a legend below them."""
    # Inches of numbers and labels, of the title of the view, and between parts; letters of 7 points are 0.1 high.
    numbers, head, gap = 0.45, 0.2 + 0.12 * (lines - 1), 0.05
    width, below = COLUMN - 2 * numbers, 0.16 * -(-entries // _ACROSS) + gap
    above, middle = min(width / plan, _TALLEST / 2), min((COLUMN - 2 * gap) / view, _TALLEST / 2)
    low = below + middle + head + numbers
    return PictureLayout(
        size=(COLUMN, low + above + numbers + 0.2),
        plan=(numbers, low, width, above),
        view=(gap, below, COLUMN - 2 * gap, middle),
        legend=0.0,
    )


_LETTERS = 60
"""Letters of a line of a column of a paper, at most."""

_ACROSS = 4
"""Entries of the legend next to one another in a column of a paper."""

DRAWN = 200
"""Cells per side above which views are drawn coarser: a column is then three pixels wide, and 120,000 polygons take two
seconds."""

_AZIMUTH, _ELEVATION = np.radians(-62), np.radians(38)
"""Direction of the view: x runs nearly to the right, and tops are seen as well as sides. At 45 degrees both sides of a
block would be equally wide, and rows behind one another hard to tell apart."""

_TOWARD = np.array([np.cos(_AZIMUTH) * np.cos(_ELEVATION), np.sin(_AZIMUTH) * np.cos(_ELEVATION), np.sin(_ELEVATION)])
"""The direction to the viewer."""

_LIT = {"top": 1.0, "x": 0.8, "y": 0.62}
"""Brightness of tops and of sides to the east and to the south, as if the sun were in the east."""

_APART, _ARROW = 0.06, 0.25
"""Distance of the arrows along x and y from the map, and their length, as shares of the mean side."""


def view_bounds(drawn: Drawable) -> Array:
    """Return the corners of the view in the plane of the picture, metres: [[left, low], [right, high]]."""
    (along_x, along_y), mean = drawn.field.extent, _mean_side(drawn)
    ends = ((-along_x / 2, along_x / 2), (-along_y / 2, along_y / 2), (0.0, float(drawn.field.heights.max())))
    x, y = (-along / 2 - _APART * mean for along in (along_x, along_y))
    label = 1.25 * _ARROW * mean
    arrows = [(x, y, 0.0), (x + label, y, 0.0), (x, y + label, 0.0)]
    points = _project(*np.array([*product(*ends), *arrows]).T)
    return np.stack([points.min(axis=0), points.max(axis=0)])


def draw_view(axes: Axes, drawn: Drawable, robot: DrawnRobot | None = None) -> str:
    """Draw the view without a title; return what the title should say."""
    from matplotlib.collections import PolyCollection

    factor = min(-(-max(drawn.field.shape) // DRAWN), *drawn.field.shape)
    field = coarse(drawn.field, factor)
    colours = cell_colours(drawn.view_colour, field)
    shapes, lit, cells = _polygons(field.heights, colours, field.block_width)
    line = 0.35 if max(field.shape) <= 60 else 0.0

    def add_blocks(part: Any) -> None:
        edges = lit[part] * 0.55
        axes.add_collection(PolyCollection(list(shapes[part]), facecolors=lit[part], edgecolors=edges, linewidths=line))

    # What is added later is drawn over what was added before.
    if robot:
        front = robot.in_front(field).ravel()[cells]
        add_blocks(~front)
        for outline, colour in robot.silhouettes(_project, _TOWARD):
            axes.fill(*outline.T, facecolor=colour, edgecolor="black", linewidth=0.6, alpha=0.85)
        add_blocks(front)
    else:
        add_blocks(slice(None))
    (left, low), (right, high) = view_bounds(drawn)
    axes.set(xlim=(left, right), ylim=(low, high), aspect="equal", anchor="C")
    axes.set_axis_off()
    # Arrows along x and y, from the corner of smallest x and y; `view_bounds` has left room for them.
    mean = _mean_side(drawn)
    start = np.array([-side / 2 - _APART * mean for side in drawn.field.extent])
    for name, along in (("x", (1, 0)), ("y", (0, 1))):
        end = start + _ARROW * mean * np.array(along)
        points = _project(*np.array([[*start, 0], [*end, 0]]).T)
        text = axes.annotate(name, xy=points[0], xytext=points[1], arrowprops={"arrowstyle": "<-"})
        text.set(ha="center", va="center", annotation_clip=False)
    return "seen from the south-east" + (f" (each column the highest of {factor} x {factor})" if factor > 1 else "")


def _polygons(heights: Array, colours: Array, width: float) -> tuple[Array, Array, Ints]:
    """Return tops and visible sides of all columns, the farthest first: (m, 4, 2) in the picture, (m, 3) colours.

    And of which cell each is, (m,).
    """
    # The farthest column is in the north-west: i ascending, j descending. A side is what rises above the neighbour.
    n_x, n_y = heights.shape
    padded = np.pad(heights, 1)
    i, j = (np.ravel(index) for index in np.meshgrid(np.arange(n_x), np.arange(n_y)[::-1], indexing="ij"))
    x0, y0 = (i - n_x / 2) * width, (j - n_y / 2) * width
    x1, y1, top = x0 + width, y0 + width, heights[i, j]
    east, south = (np.minimum(top, adjacent) for adjacent in (padded[i + 2, j + 1], padded[i + 1, j]))
    faces = {
        "top": ((x0, y0, top), (x1, y0, top), (x1, y1, top), (x0, y1, top)),
        "x": ((x1, y0, east), (x1, y1, east), (x1, y1, top), (x1, y0, top)),
        "y": ((x0, y0, south), (x1, y0, south), (x1, y0, top), (x0, y0, top)),
    }
    shapes = np.stack([np.stack([_project(*corner) for corner in corners], axis=1) for corners in faces.values()], 1)
    lit = np.stack([np.where(top[:, None] > 0, colours[i, j], GROUND_GREY) * _LIT[face] for face in faces], axis=1)
    seen = np.stack([np.ones(len(i), dtype=bool), east < top, south < top], axis=1)
    return shapes[seen], lit[seen], np.repeat(i * n_y + j, 3).reshape(-1, 3)[seen]


def _project(x: Array, y: Array, z: Array) -> Array:
    """Return points in the plane of the picture, by parallel projection."""
    across = -x * np.sin(_AZIMUTH) + y * np.cos(_AZIMUTH)
    away = -x * np.cos(_AZIMUTH) - y * np.sin(_AZIMUTH)
    return np.stack([across, z * np.cos(_ELEVATION) + away * np.sin(_ELEVATION)], axis=-1)


def _mean_side(drawn: Drawable) -> float:
    """Return the side of a square of the area of a map, metres."""
    along_x, along_y = drawn.field.extent
    return float(np.sqrt(along_x * along_y))


IMAGE_FORMATS = ("png", "svg", "pdf", "jpg", "webp")


def preview(
    shown: StepField | Scene,
    format: str = "png",  # noqa: A002  # matplotlib's word
    *,
    outlines: bool = False,
    robot: Drawn | None = None,
    at: Sequence[float] = (0.0, 0.0, 0.0),
    paper: bool = False,
) -> bytes:
    """Draw the plan and a 3D view of a field or a scene; the file of a scene carries its recipe.

    Parameters
    ----------
    shown : StepField or Scene
        What is drawn.
    format : {'png', 'svg', 'pdf', 'jpg', 'webp'}, default 'png'
        Format of the file.
    outlines : bool, default False
        Draw the outline of every obstacle on the plan; a field has none.
    robot : robot, optional
        A robot to draw too, as in `rsegen.robot_of(KIND)`.
    at : tuple of float, default (0.0, 0.0, 0.0)
        Where it is put down and settles: x, y in metres from the middle of the map, heading in radians.
    paper : bool, default False
        As wide as a column of a paper, without a title, 300 pixels per inch.

    Returns
    -------
    bytes
        The image file.

    Raises
    ------
    ParameterError
        If the robot is outside the map, or longer than it.
    """
    from matplotlib import rc_context

    refuse_other("shown", shown, Scene, StepField)
    scene = shown if isinstance(shown, Scene) else None
    field = shown.field if isinstance(shown, Scene) else shown
    drawn = robot.drawn_at(field, *at) if robot else None
    (n_x, n_y), (along_x, along_y) = field.shape, map(decimal, field.extent)
    title = f"{n_x} x {n_y} cells, {along_x} x {along_y} m"
    if scene:
        title = f"{scene.name}: {title}, seed {scene.recipe.seed}"
    with rc_context(PAPER if paper else {}):
        coloured, outlined = scene or ColouredField(field=field), scene if outlines else None
        figure = preview_figure(coloured, "" if paper else title, outlined=outlined, robot=drawn, paper=paper)
        return encoded(figure, format, to_json(scene.alone) if scene else "", is_stamped=not paper)


def preview_figure(
    drawn: Drawable, title: str, *, outlined: Scene | None = None, robot: DrawnRobot | None = None, paper: bool = False
) -> Figure:
    """Return the plan and the 3D view of a field with a legend; outlined: the scene whose obstacles are on the plan."""
    from matplotlib.figure import Figure

    # The layout needs the legend first, as it takes the width or the height that plan and view share.
    along_x, along_y = drawn.field.extent
    wide, high = np.ptp(view_bounds(drawn), axis=0)
    ratios = along_x / along_y, float(wide / high)
    entries = legend_swatches(drawn, _SWATCHES)
    words = f" {robot.describe()}" if robot else ""
    if paper:
        count = len(entries) + (len(outlined.recipe.enabled_obstacles) if outlined else 0)
        words = fill(words.strip(), _LETTERS, initial_indent="\n")
        placed = _in_a_column(*ratios, count, words.count("\n") + 1)
    else:
        placed = layout(*ratios, 2.2 if outlined else 1.6)
    figure = Figure(figsize=placed.size, dpi=DPI if paper else 100)
    plan, view = (figure.add_axes(placed.share(box)) for box in (placed.plan, placed.view))
    plan.set_title(draw_heights(plan, drawn, placed.plan[3] / _TALL if paper else 1.0))
    number_cells(plan, drawn.field)
    view.set_title(draw_view(view, drawn, robot))
    if robot:
        robot.draw(plan)
        view.set_title(f"{view.get_title()};{words}")
    shown = draw_outlines(plan, outlined) if outlined else []
    _draw_legend(figure, entries, shown, None if paper else placed.legend / placed.size[0])
    if title:
        figure.suptitle(title, y=1 - 0.12 / placed.size[1], va="top")
    return figure


def figure_of(width: float, height: float, least: float, most: float) -> Figure:
    """Return an empty figure whose parts make room for one another, of a width and a height in bounds, in inches."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, float(np.clip(height, least, most))), dpi=100, layout="constrained")


def figure_bytes(figure: Figure, scene: Scene, format: str) -> bytes:  # noqa: A002  # matplotlib's word
    """Return a figure about a map as the bytes of an image file, which carries the map's recipe."""
    return encoded(figure, format, to_json(scene.alone))


def encoded(
    figure: Figure,
    format: str,  # noqa: A002  # matplotlib's word
    recipe: str = "",
    *,
    is_stamped: bool = True,
) -> bytes:
    """Return a figure as the bytes of an image file; equal figures give equal bytes.

    recipe: what the file carries; is_stamped: whether the version of rsegen is in the lower right corner, where a
    picture without its file still shows it. A picture for a paper has it in its file alone.
    """
    from matplotlib import rc_context

    if format not in IMAGE_FORMATS:
        raise UnknownName.among("format", "format", format, IMAGE_FORMATS)
    if is_stamped:
        _stamp(figure)
    stream = io.BytesIO()
    with rc_context({"svg.hashsalt": "rsegen"}):
        figure.savefig(stream, format=format, metadata=_metadata(format, recipe))
    return stream.getvalue()


def _stamp(figure: Figure) -> None:
    """Write the version into the lower right corner, below a legend at the lower edge that would reach into it."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    wide, high = figure.get_size_inches()
    style: dict[str, Any] = {"ha": "right", "va": "bottom", "fontsize": 6, "color": "0.55", "in_layout": False}
    stamp = figure.text(1 - 0.05 / wide, 0.05 / high, _MAKER, **style)
    engine = figure.get_layout_engine()
    if not figure.legends or not isinstance(engine, ConstrainedLayoutEngine):
        return
    legend = figure.legends[0]
    canvas: Any = FigureCanvasAgg(figure)
    legend.draw(canvas.get_renderer())  # it alone: a layout that is made twice is another one
    taken = stamp.get_window_extent()
    if any(taken.overlaps(text.get_window_extent()) for text in legend.get_texts()):
        # A legend with an anchor has no room in the layout any more, so all else gets the rectangle above it.
        high, room = high + _STAMP, legend.get_window_extent().height / figure.dpi + _STAMP
        figure.set_size_inches(wide, high)
        stamp.set_y(0.05 / high)
        legend.set_bbox_to_anchor((0, _STAMP / high, 1, 1 - _STAMP / high), transform=figure.transFigure)
        engine.set(rect=(0, room / high, 1, 1 - room / high))


def pdf_bytes(figures: Iterable[Figure], scene: Scene) -> bytes:
    """Return figures about a map as the pages of a PDF, which carries the map's recipe."""
    from matplotlib.backends.backend_pdf import PdfPages

    stream = io.BytesIO()
    with PdfPages(stream, metadata={"Title": scene.name, **(_metadata("pdf", to_json(scene.alone)) or {})}) as pages:
        for figure in figures:
            pages.savefig(figure)
    return stream.getvalue()


def image_format(path: Path) -> str:
    """Return the image format of a file name; raise a FileError that lists the known ones for another name."""
    name = path.suffix.lower().removeprefix(".").replace("jpeg", "jpg")
    if name not in IMAGE_FORMATS:
        raise FileError(f"{path}: a picture's name must end in one of .{', .'.join(IMAGE_FORMATS)}")
    return name


def _draw_legend(figure: Figure, entries: list[Any], outlines: Sequence[tuple[str, str]], left: float | None) -> None:
    """Draw the swatches and a line for every outline, from `left` on, a share of the picture; None: below all else."""
    from matplotlib.lines import Line2D

    lines = [Line2D([], [], color=colour, linewidth=2.5, label=text) for colour, text in outlines[:_SWATCHES]]
    entries = [*entries, *lines]
    if len(outlines) > _SWATCHES:
        entries.append(Line2D([], [], linewidth=0, label=f"and {len(outlines) - _SWATCHES} more"))
    if entries and left is None:
        room: dict[str, float] = {"columnspacing": 1.0, "handlelength": 1.2, "handletextpad": 0.4, "borderaxespad": 0.1}
        figure.legend(handles=in_rows(entries, _ACROSS), loc="lower center", ncols=_ACROSS, frameon=False, **room)
    elif entries:
        size = 10 if len(entries) <= _SWATCHES else 6  # of more than one column of entries
        figure.legend(handles=entries, loc="center left", bbox_to_anchor=(left, 0.5), frameon=False, fontsize=size)


def in_rows(entries: Sequence[Any], across: int) -> list[Any]:
    """Return entries of a legend in such an order that they are read row by row: matplotlib fills columns."""
    return [entry for column in range(across) for entry in entries[column::across]]


_SWATCHES = 18
"""Entries of a legend, of each sort, at most."""


_MAKER = f"rsegen {__version__}"

_STAMP = 0.12
"""Inches below a legend that the version of rsegen takes."""


def _metadata(format: str, recipe: str) -> dict[str, Any] | None:  # noqa: A002  # matplotlib's word
    """Return what made a picture and its recipe, if the format has a place for them, and no date."""
    carried = recipe or None  # matplotlib leaves out what is None
    known: dict[str, dict[str, Any]] = {
        "png": {"Software": _MAKER} | ({"Description": recipe} if recipe else {}),
        "svg": {"Creator": _MAKER, "Description": carried, "Date": None},
        "pdf": {"Creator": _MAKER, "Subject": carried, "CreationDate": None},
    }
    return known.get(format)


THUMBNAIL = 320
"""Pixels along the longer side of a small plan, at most."""


def thumbnail(shown: StepField | Scene) -> bytes:
    """Return a small plan as the bytes of a PNG file, north up; large fields show the highest of several cells."""
    from PIL import Image

    drawn: Drawable = ColouredField(field=shown) if isinstance(shown, StepField) else shown
    field = coarse(drawn.field, coarseness(drawn.field, THUMBNAIL))
    pixels = max(THUMBNAIL // max(field.shape), 1)
    colours = np.rint(255 * cell_colours(drawn.plan_colour, field)).astype(np.uint8).transpose(1, 0, 2)[::-1]
    stream = io.BytesIO()
    Image.fromarray(colours.repeat(pixels, axis=0).repeat(pixels, axis=1)).save(stream, "png")
    return stream.getvalue()
