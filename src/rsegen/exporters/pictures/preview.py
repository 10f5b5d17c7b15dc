"""The preview of a map: a plan with its heights and a 3D view; it needs no display."""

from __future__ import annotations

import io
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rsegen.errors import FileError
from rsegen.exporters.numbers import decimal
from rsegen.exporters.pictures.layout import layout
from rsegen.exporters.pictures.oblique_view import draw_view, view_bounds
from rsegen.exporters.pictures.outlines import draw_outlines
from rsegen.exporters.pictures.plan import Drawable, draw_heights, number_cells
from rsegen.exporters.scene import Scene
from rsegen.recipe.codec import to_json

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FORMATS = ("png", "svg", "pdf", "jpg", "webp")


def preview_image(scene: Scene, format: str = "png", *, outlines: bool = False) -> bytes:  # noqa: A002  # matplotlib's word
    """The plan and the 3D view of a map as the bytes of an image file; outlines: of its obstacles, on the plan."""
    return figure_bytes(preview_figure(scene, _title(scene), outlined=scene if outlines else None), scene, format)


def preview_figure(drawn: Drawable, title: str, *, outlined: Scene | None = None) -> Figure:
    """The plan and the 3D view of a field, with a legend of its heights; outlined: whose obstacles are on the plan."""
    from matplotlib.figure import Figure

    along_x, along_y = drawn.field.extent
    wide, high = np.ptp(view_bounds(drawn), axis=0)
    placed = layout(along_x / along_y, float(wide / high), 2.2 if outlined else 1.6)
    figure = Figure(figsize=placed.size, dpi=100)
    plan, view = (figure.add_axes(placed.share(box)) for box in (placed.plan, placed.view))
    plan.set_title(draw_heights(plan, drawn))
    number_cells(plan, drawn.field)
    view.set_title(draw_view(view, drawn))
    shown = draw_outlines(plan, outlined) if outlined else []
    _draw_legend(figure, drawn, placed.legend / placed.size[0], shown)
    figure.suptitle(title, y=1 - 0.12 / placed.size[1], va="top")
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


def _draw_legend(figure: Figure, drawn: Drawable, left: float, outlines: Sequence[tuple[str, str]]) -> None:
    """Draw a swatch for every height that the map has, at most _SWATCHES of them, and a line for every outline."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    levels = [level for level in drawn.field.level_counts() if level]
    shown = levels[:: -(-len(levels) // _SWATCHES) or 1]
    unit = drawn.field.unit * 100
    entries: list[Any] = [Patch(facecolor=drawn.colour(each), label=f"{decimal(each * unit)} cm") for each in shown]
    if drawn.field.frame.any():
        frame = decimal(drawn.field.frame_height * 100)
        entries.append(Patch(facecolor=drawn.colour(0), label=f"frame, {frame} cm"))
    for colour, text in outlines[:_SWATCHES]:
        entries.append(Line2D([], [], color=colour, linewidth=2.5, label=text))
    if len(outlines) > _SWATCHES:
        entries.append(Line2D([], [], linewidth=0, label=f"and {len(outlines) - _SWATCHES} more"))
    if entries:
        size = 10 if len(entries) <= _SWATCHES else 6
        figure.legend(handles=entries, loc="center left", bbox_to_anchor=(left, 0.5), frameon=False, fontsize=size)


_SWATCHES = 18
"""Entries of a legend, of each sort, at most."""


def _title(scene: Scene) -> str:
    n_x, n_y = scene.field.shape
    along_x, along_y = map(decimal, scene.field.extent)
    return f"{scene.name}: {n_x} x {n_y} cells, {along_x} x {along_y} m, seed {scene.recipe.seed}"


def _metadata(scene: Scene, format: str) -> dict[str, Any] | None:  # noqa: A002  # matplotlib's word
    """The recipe of the map, if the format has a place for it, and no date: the same map gives the same bytes."""
    recipe = to_json(scene.alone)
    known: dict[str, dict[str, Any]] = {
        "png": {"Description": recipe},
        "svg": {"Description": recipe, "Date": None},
        "pdf": {"Subject": recipe, "CreationDate": None},
    }
    return known.get(format)
