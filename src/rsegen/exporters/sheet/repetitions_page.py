"""A form for the repetitions of a test on the map: attempts, successes, times."""

from __future__ import annotations

from rsegen.exporters.fingerprint import fingerprint
from rsegen.exporters.scene import Scene
from rsegen.exporters.sheet.page import GREY, Page

_HEAD = (("Robot", 0, 85), ("Operator", 95, 85), ("Place and date", 0, 85), ("Time allowed", 95, 85))
_COLUMNS = (("no.", 10), ("start", 26), ("goal", 26), ("time", 26), ("success", 20), ("what happened", 72))
_ROWS = 30
_ROW = 6.2


def draw_form(page: Page, scene: Scene) -> None:
    """Draw the whole page."""
    page.text(page.left, 22, "Repetitions", 20, fontweight="bold")
    about = f"{scene.name}, fingerprint {fingerprint(scene.field.blocks)}; from start (west) to goal (east)"
    page.fitted((page.left, 29), about, 9, page.across)
    for number, (text, x, width) in enumerate(_HEAD):
        y = 40.0 + 9 * (number // 2)
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
