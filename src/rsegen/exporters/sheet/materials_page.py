"""The page of what a map needs besides its blocks: frame boards and how to cut them, base boards, weight and cost."""

from __future__ import annotations

from collections.abc import Iterator

from rsegen.exporters.lengths import Lengths, lengths_in
from rsegen.exporters.scene import Scene
from rsegen.exporters.sheet.cut_list import COLUMN
from rsegen.exporters.sheet.cutting import CutSettings, nanometres
from rsegen.exporters.sheet.materials import Materials, materials
from rsegen.exporters.sheet.overview import RIGHT, draw_patterns, stock_length
from rsegen.exporters.sheet.page import ROW, Page

_STEPS = (
    "Cut the frame boards first: two as long as the frame",
    "is outside, and two between them. Screw the corners,",
    "and the frame to its base board.",
    "",
    "Try a row of blocks in the frame before all are cut.",
    "Place them in the order of the pallet's page. They",
    "stand by themselves between the frame and one another;",
    "to move a pallet, fix each with glue, or with a screw",
    "from below through the base board.",
    "",
    "Lengths are those of finished parts. Wood swells: give",
    "blocks some play in the frame (--play-mm).",
)


def draw_materials(page: Page, scene: Scene, settings: CutSettings) -> None:
    """Draw the whole page."""
    found, written = materials(scene.field, scene.recipe, settings), lengths_in(scene.recipe.units)
    page.text(page.left, 22, "Frames, bases and cost", 20, fontweight="bold")
    page.fitted((page.left, 29), scene.name, 9, page.across)
    y = 40.0
    for heading, rows in (
        ("Frames", list(_frames(found, scene, settings, written))),
        ("Base boards", [(f"{found.bases:,} of {_by(found.base, written)}", "")]),
        ("Weight", list(_weight(found, settings, written))),
        ("Cost", list(_cost(found, settings))),
    ):
        y = page.heading(page.left, y, heading, COLUMN)
        for text, amount in rows:
            page.text(page.left, y, text)
            page.text(page.left + COLUMN, y, amount, ha="right")
            y += ROW
        y += 4
    y = 40.0
    if found.boards:
        y = page.heading(RIGHT, y, f"Cutting {stock_length(scene, settings)} of stock", COLUMN)
        y = draw_patterns(page, found.boards, y, written) + 4
    y = page.heading(RIGHT, y, "How to build it", COLUMN)
    for text in _STEPS:
        page.text(RIGHT, y, text, 8.2)
        y += 4.4 if text else 2


def _frames(found: Materials, scene: Scene, settings: CutSettings, written: Lengths) -> Iterator[tuple[str, str]]:
    if found.frames is None:
        yield "none", ""
        return
    section = tuple(nanometres(each) for each in (scene.recipe.block_width_cm, scene.recipe.frame_height_cm))
    yield f"boards, {_by(section, written)} high", written.long(found.frames.timber)
    for one, count in found.frames.all_boards.items():
        yield f"  {count:,} of {written.short(one)} {written.unit}", written.long(one * count)
    if found.boards:
        yield (
            f"stock of {stock_length(scene, settings)}",
            f"{found.boards.pieces:,} piece{'s'[: found.boards.pieces != 1]}",
        )
    else:
        yield f"they are longer than {stock_length(scene, settings)} of stock", ""


def _by(sides: tuple[int, ...], written: Lengths) -> str:
    return f"{' x '.join(map(written.short, sides))} {written.unit}"


def _weight(found: Materials, settings: CutSettings, written: Lengths) -> Iterator[tuple[str, str]]:
    yield f"blocks, of {settings.density:g} kg/m3", written.weight(found.block_weight)
    if found.frames:
        yield "frames", written.weight(found.frame_weight)


def _cost(found: Materials, settings: CutSettings) -> Iterator[tuple[str, str]]:
    if settings.price is None:
        yield "no price given (--price, --frame-price)", ""
        return
    yield f"blocks: {found.blocks.pieces:,} x {settings.price:,.2f}", f"{found.blocks.pieces * settings.price:,.2f}"
    if found.boards and settings.frame_price is not None:
        yield (
            f"frames: {found.boards.pieces:,} x {settings.frame_price:,.2f}",
            f"{found.boards.pieces * settings.frame_price:,.2f}",
        )
    yield "together, without base boards", "" if found.price is None else f"{found.price:,.2f}"
