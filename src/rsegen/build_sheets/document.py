"""The build sheet: instructions for building a map in wood, as PDF or CSV.

Scene --pages--> a page for the map, and one for each pallet --> PDF
Scene --listing--> a row for each cell --> CSV, which `rsegen import` reads
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from rsegen.build_sheets.cut_settings import CutSettings
from rsegen.build_sheets.listing import listing
from rsegen.build_sheets.timber import building_order, materials
from rsegen.errors import FileError, ParameterError, UnknownName
from rsegen.pictures.preview import pdf_bytes
from rsegen.recipe.recipe import Recipe
from rsegen.scene.scene import Scene

if TYPE_CHECKING:
    from matplotlib.figure import Figure


SHEET_FORMATS = ("pdf", "csv")

MOST_PALLETS = 400
"""Pallets of a sheet, at the most: a page for each."""

LARGEST_PALLET = 60
"""Blocks per side of a pallet, at the most: more are not legible on A4."""

MOST_BLOCKS = 40_000
"""Blocks of a sheet, at the most: nobody places more by hand, and each is a text of the PDF."""


def sheet(
    scene: Scene,
    saw: CutSettings | None = None,
    format: str = "pdf",  # noqa: A002  # matplotlib's word
    *,
    progress: Callable[[Figure], None] | None = None,
) -> bytes:
    """Return the build sheet of a map as the bytes of a file.

    Parameters
    ----------
    scene : Scene
        The map.
    saw : CutSettings, optional
        Kerf, stock length and so on; by default as usual in the recipe's units.
    format : {'pdf', 'csv'}, default 'pdf'
        Format of the file.
    progress : callable, optional
        Called with each page of a PDF.

    Returns
    -------
    bytes
        The file.

    Raises
    ------
    ParameterError
        If the map is too large for it.
    """
    saw = saw or CutSettings.default(scene.recipe.units)
    if format not in SHEET_FORMATS:
        raise UnknownName.among("format", "format", format, SHEET_FORMATS)
    refuse_unbuildable(scene.recipe, saw)
    if format == "csv":
        return "".join(listing(scene, saw)).encode()
    return pdf_bytes(pages(scene, saw, progress or (lambda _: None)), scene)


def pages(scene: Scene, saw: CutSettings, progress: Callable[[Figure], None] = lambda _: None) -> Iterator[Figure]:
    """Yield the pages: the map, each pallet in build order, frames and cost, and a form for repetitions."""
    # Each page is yielded before the next is drawn, so that only one is in memory.
    from rsegen.build_sheets.overview import draw_materials, draw_overview
    from rsegen.build_sheets.page import Page
    from rsegen.build_sheets.pallet_page import draw_form, draw_pallet

    pallets, needed = building_order(scene), materials(scene.field, scene.recipe, saw)
    own = [partial(draw_pallet, scene=scene, numbered=pallet, pallets=len(pallets)) for pallet in pallets]
    whole = partial(draw_overview, scene=scene, pallets=pallets, needed=needed)
    for draw in (whole, *own, partial(draw_materials, scene=scene, needed=needed), partial(draw_form, scene=scene)):
        page = Page(scene.recipe.units)
        draw(page)
        yield page.figure
        progress(page.figure)


def page_count(recipe: Recipe) -> int:
    """Return the number of pages of the sheet of each map of a recipe."""
    m_x, m_y = recipe.chunks
    return 3 + m_x * m_y


def sheet_format(path: Path) -> str:
    """Return the sheet format of a file name; raise a FileError that lists the known ones for another name."""
    name = path.suffix.lower().removeprefix(".")
    if name not in SHEET_FORMATS:
        raise FileError(f"{path}: a build sheet must be a .pdf or .csv file")
    return name


def refuse_unbuildable(recipe: Recipe, saw: CutSettings) -> None:
    """Raise a ParameterError if a map is too large to build by hand, or a block is longer than the stock."""
    if recipe.chunk_size > LARGEST_PALLET:
        problem = f"{recipe.chunk_size} blocks per side do not fit on a page of a build sheet"
        raise ParameterError("chunk_size", f"{problem}; use up to {LARGEST_PALLET}")
    (m_x, m_y), (n_x, n_y) = recipe.chunks, recipe.grid.shape
    if m_x * m_y > MOST_PALLETS or n_x * n_y > MOST_BLOCKS:
        problem = f"{m_x * m_y:,} pallets with {n_x * n_y:,} blocks are too many for a build sheet"
        raise ParameterError("chunks", f"{problem}; use up to {MOST_PALLETS} with {MOST_BLOCKS:,}")
    saw.check(recipe.highest_level * recipe.unit_cm, "blocks of the highest level")
