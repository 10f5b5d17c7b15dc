"""The cut list on a page: the blocks of a map or pallet with their lengths, numbers and timber."""

from __future__ import annotations

from collections.abc import Mapping

from rsegen.exporters.lengths import lengths_in
from rsegen.exporters.scene import Scene
from rsegen.exporters.sheet.order import length
from rsegen.exporters.sheet.page import GREY, ROW, Page
from rsegen.exporters.sheet.plan_view import EMPTY
from rsegen.field.stepfield import StepField

COLUMN = 82.0
"""The width of the list in millimetres."""

_ABREAST = 3
"""The number of narrow columns for lists that are too long for one column."""


def draw_cut_list(page: Page, scene: Scene, field: StepField, place: tuple[float, float], bottom: float) -> float:
    """Draw the cut list above `bottom`, counting what does not fit; returns the y of the next line."""
    x, y = place
    y = page.heading(x, y, "Blocks to cut", COLUMN)
    counts = {level: count for level, count in field.level_counts().items() if level}
    room = max(1, int((bottom - y) / ROW) - 2)
    draw = _draw_table if len(counts) < room else _draw_narrow
    y = draw(page, scene, counts, (x, y), room)
    whole = sum(length(level, field) * count for level, count in counts.items())
    page.line((x, x + COLUMN), (y - 3.6, y - 3.6))
    total = ("together", f"{sum(counts.values()):,}", lengths_in(scene.recipe.units).long(whole))
    y = page.table(y, _columns(x)[1:], [total], fontweight="bold")
    page.swatch(x, y, EMPTY)
    page.text(x + 3, y, "0", 8, ha="center", color=GREY)
    empty = field.level_counts().get(0, 0)
    page.text(x + 9, y, f"no block: {empty:,} cell{'s'[: empty != 1]}", 9)
    return y + ROW


def _columns(x: float) -> list[float]:
    return [x + 20, x + 40, x + 60, x + COLUMN]


def _draw_table(page: Page, scene: Scene, counts: Mapping[int, int], place: tuple[float, float], room: int) -> float:
    """Draw a line per level; returns the y of the next line."""
    (x, y), written = place, lengths_in(scene.recipe.units)
    y = page.table(y, _columns(x), [("level", f"length {written.name}", "number", "timber")], size=8, color=GREY)
    for level, count in counts.items():
        page.swatch(x, y, scene.colour(level))
        one = length(level, scene.field)
        y = page.table(y, _columns(x), [(str(level), written.short(one), f"{count:,}", written.long(one * count))])
    return y


def _draw_narrow(page: Page, scene: Scene, counts: Mapping[int, int], place: tuple[float, float], room: int) -> float:
    """Draw several levels per line, in narrow columns; returns the y of the next line."""
    (x, y), width = place, (COLUMN + 4) / _ABREAST
    page.text(x, y, f"number x length in {lengths_in(scene.recipe.units).name}", 8, color=GREY)
    rows = max(1, min(room - 2, -(-len(counts) // _ABREAST)))
    for at, (level, count) in enumerate(list(counts.items())[: rows * _ABREAST]):
        here = x + at // rows * width, y + (at % rows + 1) * ROW
        page.swatch(*here, scene.colour(level))
        page.text(
            here[0] + 8, here[1], f"{count:,} x {lengths_in(scene.recipe.units).short(length(level, scene.field))}", 8
        )
    y += (rows + 1) * ROW
    if len(counts) > rows * _ABREAST:
        more = len(counts) - rows * _ABREAST
        page.text(x, y, f"and {more} more lengths, which the sheet as CSV has", 8, color=GREY)
        y += ROW
    return y
