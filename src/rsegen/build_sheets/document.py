"""The build sheet: instructions for building a map in wood, as PDF or CSV.

Scene --pages--> a page for the map, and one for each pallet --> PDF
Scene --listing--> comments on what to cut, a row for each cell --> CSV, which `rsegen import` reads
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from rsegen import __version__
from rsegen.build_sheets.cut_settings import CutSettings, nanometres
from rsegen.build_sheets.timber import (
    CuttingPlan,
    building_order,
    length,
    length_counts,
    losses,
    materials,
    placing_order,
    too_short,
    unknown_price,
)
from rsegen.build_sheets.timber_lengths import TimberLengths, timber_lengths_in
from rsegen.errors import FileError, ParameterError, UnknownName, refuse_other
from rsegen.heights.table import COLUMNS, RECIPE_KEYS
from rsegen.params.numbers import decimal
from rsegen.pictures.preview import pdf_bytes
from rsegen.recipe.recipe import Recipe
from rsegen.scene.scene import Scene, compose, fingerprint
from rsegen.writing.resources import refuse_too_large
from rsegen.writing.store import refuse_taken_file, write_files

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
    refuse_other("scene", scene, Scene)
    saw = saw or CutSettings.default(scene.recipe.units)
    if format not in SHEET_FORMATS:
        raise UnknownName.among("format", "format", format, SHEET_FORMATS)
    refuse_unbuildable(scene.recipe, saw)
    if format == "csv":
        return "".join(listing(scene, saw)).encode()
    return pdf_bytes(pages(scene, saw, progress or (lambda _: None)), scene)


def write_sheets(
    recipe: Recipe, index: int, paths: Iterable[Path], saw: CutSettings | None = None, *, force: bool = False
) -> Scene:
    """Write the build sheet of one map into files, each in the format that its name asks for; gives the map.

    All are made before the first is written. Raises an OutputError if a file exists already, unless `force`; TooLarge
    or a ParameterError if the map cannot have a sheet.
    """
    # Everything that may be wrong is checked first, as a map and its sheet take their time.
    saw = saw or CutSettings.default(recipe.units)
    formats = {path: sheet_format(path) for path in paths}
    for path in formats:
        refuse_taken_file(path, force=force)
    refuse_too_large(recipe)
    refuse_unbuildable(recipe, saw)
    scene = compose(recipe, index)
    write_files({path: [sheet(scene, saw, format_)] for path, format_ in formats.items()}, force=force)
    return scene


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
    highest = nanometres(recipe.highest_level * recipe.unit_cm)
    saw.check(highest, "blocks of the highest level", recipe.units)


def listing(scene: Scene, settings: CutSettings) -> Iterator[str]:
    """Yield the lines of the CSV file; `#` starts a comment, and no comment has a comma."""
    yield f"# build sheet of {scene.name} with seed {scene.recipe.seed}\n"
    yield f"# rsegen {__version__}\n"
    yield f"# fingerprint of the levels: {fingerprint(scene.field.blocks)}\n"
    for name in RECIPE_KEYS:
        value = getattr(scene.recipe, name)
        if name != "units" or value != "cm":
            yield f"# {name}: {decimal(value) if isinstance(value, float) else value}\n"
    written = timber_lengths_in(scene.recipe.units)
    yield from _timber(scene, settings, written)
    yield "# x (to the east) and y (to the north) count the cells of the map from 0 on with frames left out\n"
    yield "# order of placing in each pallet: row by row from the north-west; a cell without a block has none\n"
    pallets = building_order(scene)
    for pallet in pallets if len(pallets) > 1 else ():
        yield f"# fingerprint of {pallet.name}: {fingerprint(pallet.levels)}\n"
    yield ",".join((*COLUMNS[:-1], f"height_{written.unit}")) + "\n"
    # From the north-west, row by row: in the order in which the blocks are placed.
    for pallet in pallets:
        levels, order = pallet.levels, placing_order(pallet.levels)
        for j in range(levels.shape[1])[::-1]:
            for i in range(levels.shape[0]):
                x, y = pallet.corner[0] + i, pallet.corner[1] + j
                height = written.short(length(int(levels[i, j]), scene.field))
                yield f"{pallet.name},{order[i, j] or ''},{x},{y},{height}\n"


def _timber(scene: Scene, settings: CutSettings, written: TimberLengths) -> Iterator[str]:
    needed = materials(scene.field, scene.recipe, settings)
    for block, count in length_counts(scene.field).items():
        yield f"# cut: {_counted(count, 'block')} of {written.tape(block)} {written.unit}\n"
    yield from _plan("blocks", "saw", needed.blocks, written)
    for board, count in needed.frames.items():
        yield f"# frames: {_counted(count, 'board')} of {written.tape(board)} {written.unit}\n"
    if needed.boards:
        yield from _plan("frames", "saw for frames", needed.boards, written)
    if short := " ".join(too_short(needed, written)):
        yield f"# stock for the frames: {short}\n"
    yield f"# base boards: {needed.bases} of {' x '.join(map(written.tape, needed.base))} {written.unit}\n"
    weights = f"{written.weight(needed.block_weight)} blocks + {written.weight(needed.frame_weight)} frames"
    yield f"# weight: {weights}\n".replace(",", "")
    if needed.price is not None:
        yield f"# cost without base boards: {needed.price:.2f}\n"
    elif settings.price is not None:
        yield f"# cost of the blocks: {needed.blocks.pieces * settings.price:.2f}\n"
        yield f"# cost of the frames: {unknown_price(needed)}\n"


def _plan(what: str, saw: str, plan: CuttingPlan, written: TimberLengths) -> Iterator[str]:
    stock = f"{_counted(plan.pieces, 'piece')} of {written.stock(plan.settings.stock)}"
    ends = f"{written.tape(plan.settings.trim)} {written.unit} of ends"
    yield f"# stock for the {what}: {stock} less {losses(plan.settings, written)} and {ends}\n"
    for pattern in plan.patterns:
        parts = " + ".join(f"{count} x {written.tape(part)} {written.unit}" for part, count in pattern.parts)
        yield f"# {saw}: {_counted(pattern.pieces, 'piece')} into {parts}\n"


def _counted(count: int, what: str) -> str:
    """Return a count in words, without a comma: 1 piece, 1200 pieces."""
    return f"{count} {what}{'s'[: count != 1]}"
