"""The pages of a build sheet for the builder and the tester: one of each pallet, and a form for repetitions.

A pallet's page has every cell with the height of its block, the order of placing and the cut list. The form is for the
repetitions of a test on the map: attempts, successes, times.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from rsegen.build_sheets.overview import SMALLEST, draw_cut_list
from rsegen.build_sheets.page import GREY, INK, POINT, Page, PrintedPlan, block_colour
from rsegen.build_sheets.timber import NumberedPallet, length, placing_order
from rsegen.pictures.plan import ink_on
from rsegen.scene.scene import Scene, fingerprint

ORDERED = 12
"""Blocks per side up to which a pallet's cells have the placing order: smaller ones have no room for two numbers."""

_TOP, _LISTS = 40.0, 70.0
"""Upper end of the plan, and height of the lists below it, in millimetres; the plan has the rest of the page."""

_LINED = 1.5
"""Smallest side of a pallet, in millimetres, at which the small map of all pallets has lines between them."""

_PLACING = (
    "Place row by row from the north-west corner, as one",
    "reads: stand at the south side and fill the far row first.",
    "Cells with their corners marked have no block.",
)
_RULE = (
    "Seen from above. x and y count the cells of the map",
    "from 0 in its south-west corner, x to the east, y to",
    "the north, frames left out, as in the recipe.",
)


def draw_pallet(page: Page, scene: Scene, numbered: NumberedPallet, pallets: int) -> None:
    """Draw the page of a pallet."""
    (x, y), (n_x, n_y) = numbered.corner, numbered.levels.shape
    page.text(page.left, 22, f"Pallet {numbered.name}", 20, fontweight="bold")
    where = f"cells {x}..{x + n_x - 1} along x, {y}..{y + n_y - 1} along y"
    name = f"fingerprint {fingerprint(numbered.levels)}"
    order = f"{scene.name}, {numbered.number} of {pallets} in the order of building; {where}; {name}"
    page.fitted((page.left, 29), order, 9, page.across - (52 if pallets > 1 else 12))
    page.compass()
    if pallets > 1:
        _draw_position(page, scene, numbered)
    # The plan, and below it the lists.
    field = numbered.chunk.field
    cell = (page.bottom - _LISTS - _TOP) / max(field.shape)
    left = page.left + (page.across - field.shape[0] * cell) / 2
    plan = PrintedPlan(page=page, scene=scene, field=field, left=left, top=_TOP, cell=cell)
    plan.draw(0.5)
    _draw_rulers(plan, numbered)
    notes = _draw_blocks(plan, numbered)
    below = _TOP + field.shape[1] * cell + 14
    draw_cut_list(page, scene, field, (page.left, below), page.bottom + 3)
    page.instructions(below, (*_PLACING, "", *notes, "", *_RULE))


def _draw_position(page: Page, scene: Scene, numbered: NumberedPallet) -> None:
    """Draw the position of the pallet among the others, next to the compass."""
    m_x, m_y = scene.recipe.chunks
    i, j = numbered.chunk.index
    cell = min(36 / m_x, 18 / m_y, 6)
    left, top, right, bottom = page.right - 12 - m_x * cell, 29 - m_y * cell, page.right - 12, 29.0
    if cell > _LINED:
        for column in range(1, m_x):
            page.line((left + column * cell,) * 2, (top, bottom))
        for row in range(1, m_y):
            page.line((left, right), (top + row * cell,) * 2)
    page.rectangle((left, top), (right - left, bottom - top))
    page.rectangle((left + i * cell, bottom - (j + 1) * cell), (cell, cell), facecolor=INK)


def _draw_rulers(plan: PrintedPlan, numbered: NumberedPallet) -> None:
    """Draw cell numbers on all four sides: all of them, or every fifth if they would overlap."""
    far_x, far_y = (cells * plan.cell for cells in plan.field.shape)
    size, step = (8, 1) if plan.cell > 5 else (6, 5)
    style = {"color": GREY, "ha": "center", "va": "center"}
    for axis, sides in enumerate(((plan.top - 3, plan.top + far_y + 3), (plan.left - 4, plan.left + far_x + 4))):
        for at, cell in enumerate(plan.field.inside(axis).nonzero()[0].tolist(), numbered.corner[axis]):
            middle = plan.middle(cell, cell)[axis]
            for side in sides if at % step == 0 else ():
                x, y = (side, middle) if axis else (middle, side)
                plan.page.text(x, y, str(at), size, **style)
    plan.page.text(plan.left + far_x / 2, plan.top + far_y + 8, "x", 9, **style)
    plan.page.text(plan.left - 10, plan.top + far_y / 2, "y", 9, **style)


_SMALL = 5.5
"""Font size of the placing order in points, at the least: cells of ORDERED blocks per side have room for it."""


def _draw_blocks(plan: PrintedPlan, numbered: NumberedPallet) -> tuple[str, ...]:
    """Draw the height of every block, and its placing order if there is room; return notes that explain them."""
    levels, order = numbered.levels, placing_order(numbered.levels)
    texts, notes = _labels(plan)
    size, ordered = _size(plan.cell, texts), max(levels.shape) <= ORDERED
    cells = product(*(plan.field.inside(axis).nonzero()[0].tolist() for axis in (0, 1)))
    for at, cell in zip(np.ndindex(levels.shape), cells, strict=True):
        level, (x, y) = int(levels[at]), plan.middle(*cell)
        style = {"color": ink_on(block_colour(plan.scene, level)) if level else GREY}
        plan.page.text(x, y, texts[level], size, ha="center", va="center", **style)
        if ordered and level:
            corner = 0.44 * plan.cell
            plan.page.text(x - corner, y - corner, str(order[at]), min(7.0, max(size / 2, _SMALL)), va="top", **style)
    last = "Small numbers are the order of placing." if ordered else "The sheet as CSV has the order of placing."
    return (*notes, last)


def _labels(plan: PrintedPlan) -> tuple[dict[int, str], tuple[str, ...]]:
    """Return the text of each level in the cells, and the notes that explain it."""
    field, written = plan.field, plan.page.written
    heights = {level: written.tape(length(level, field)) for level in field.level_counts()}
    if _size(plan.cell, heights) >= SMALLEST:
        return heights, (f"Large numbers are heights in {written.name}.",)
    unit = written.short(length(1, field))
    notes = "Numbers are levels, for want of room: a block of", f"level n is n x {unit} {written.unit} long."
    return {level: str(level) for level in heights}, notes


def _size(cell: float, texts: dict[int, str]) -> float:
    """Return the font size with which the longest of the texts fits into a cell; a digit is 0.64 of it wide.

    Blanks and strokes of fractions are half as wide.
    """
    widest = max(len(text) - (text.count(" ") + text.count("/")) / 2 for text in texts.values())
    return min(18.0, 0.85 * cell / POINT / (0.64 * max(widest, 2)))


_HEAD = (("Robot", 0, 85), ("Operator", 95, 85), ("Place and date", 0, 85), ("Time allowed", 95, 85))
_COLUMNS = (("no.", 10), ("start", 26), ("goal", 26), ("time", 26), ("success", 20), ("what happened", 72))
_ROWS = 30
"""Attempts of a form: 30 fill the page."""

_ROW = 6.2
"""Height of a row in millimetres, for handwriting."""


def draw_form(page: Page, scene: Scene) -> None:
    """Draw the form for repetitions of a test."""
    page.text(page.left, 22, "Repetitions", 20, fontweight="bold")
    about = f"{scene.name}, fingerprint {fingerprint(scene.field.blocks)}; from start (west) to goal (east)"
    page.fitted((page.left, 29), about, 9, page.across)
    # Two lines of two fields to fill in, a table with a row per attempt, and a line for the totals.
    for field, (text, x, width) in enumerate(_HEAD):
        y = 40.0 + 9 * (field // 2)
        page.text(page.left + x, y, text, 8, color=GREY)
        page.line((page.left + x + 24, page.left + x + width), (y + 1, y + 1))
    top = 60.0
    left = page.left
    for name, column in _COLUMNS:
        page.text(left + 1.5, top - 2, name, 8, color=GREY)
        page.rectangle((left, top), (column, _ROWS * _ROW))
        left += column
    for row in range(_ROWS):
        y = top + row * _ROW
        page.line((page.left, page.right), (y, y))
        page.text(page.left + 8.5, y + 4.3, str(row + 1), 8, ha="right", color=GREY)
    y = top + _ROWS * _ROW + 9
    for at, text in enumerate(("attempts", "successes", "mean time")):
        page.text(page.left + 62 * at, y, text, 9, fontweight="bold")
        page.line((page.left + 62 * at + 24, page.left + 62 * at + 54), (y + 1, y + 1))
