"""A page with positions in millimetres from the upper left corner, and plans on it, north up.

A plan has cells in the colours of their levels, frames hatched, and marked corners if a cell has no block.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from rsegen.build_sheets.timber_lengths import timber_lengths_in
from rsegen.field.stepfield import Array, Ints, StepField
from rsegen.scene.colours import Colour
from rsegen.scene.scene import Scene

if TYPE_CHECKING:
    from matplotlib.figure import Figure


A4, LETTER = (210.0, 297.0), (215.9, 279.4)
"""Papers in millimetres, of ISO 216 and, for sheets in inches, of ANSI: what is printed must not be scaled to fit."""

MARGIN = 15.0
"""Margin in millimetres, which every printer leaves."""

COLUMN = 82.0
"""Width of a list in millimetres: two of them fit between the margins."""

INCH = 25.4
POINT = INCH / 72
"""A typographic point in millimetres."""

INK, GREY, PALE = "#1a1a1a", "#666666", "#bbbbbb"
ROW = 5.2
"""Line height of tables in millimetres: 14.7 points for texts of 9."""


class Page:
    """A page of vector graphics: A4, or Letter if a recipe is in inches; `across` is the width between its margins.

    second: x of the right one of two columns; written: the units of lengths
    """

    def __init__(self, units: str) -> None:
        from matplotlib.figure import Figure

        self.written = timber_lengths_in(units)
        width, height = LETTER if units == "in" else A4
        self.left, self.right, self.bottom = MARGIN, width - MARGIN, height - MARGIN
        self.across = width - 2 * MARGIN
        self.second = self.right - COLUMN
        self.figure: Figure = Figure(figsize=(width / INCH, height / INCH), dpi=100)
        self.paper = self.figure.add_axes((0, 0, 1, 1))
        self.paper.set(xlim=(0, width), ylim=(height, 0))
        self.paper.set_axis_off()

    def text(self, x: float, y: float, text: str, size: float = 9, **style: Any) -> None:
        """Draw a text with its base line at y; its size is in points."""
        self.paper.text(x, y, text, fontsize=size, parse_math=False, **{"color": INK, **style})

    def fitted(self, place: tuple[float, float], text: str, size: float, room: float, **style: Any) -> None:
        """Draw a text in a smaller font if it does not fit into `room` millimetres."""
        from matplotlib.font_manager import FontProperties, findfont, get_font
        from matplotlib.textpath import TextPath

        font = FontProperties(weight=style.get("fontweight", "normal"), size=size)
        drawn = get_font(findfont(font))
        known = "".join(letter if drawn.get_char_index(ord(letter)) else "?" for letter in text)
        plain = known.replace("$", "S")  # which a path of a text would take for a formula
        # matplotlib knows the width of a text only once it is drawn, but the one of its outline at once.
        width = TextPath((0, 0), plain, prop=font).get_extents().width if plain.strip() else 0.0
        self.text(*place, known, size * min(1.0, room / POINT / max(width, 1)), **style)

    def line(self, xs: Sequence[float], ys: Sequence[float], width: float = 0.4, colour: str = PALE) -> None:
        """Draw a line through points; its width is in points."""
        self.paper.plot(xs, ys, color=colour, linewidth=width, solid_capstyle="butt")

    def rectangle(self, place: tuple[float, float], size: tuple[float, float], **style: Any) -> None:
        """Draw a rectangle from its upper left corner."""
        from matplotlib.patches import Rectangle

        style = {"linewidth": 0.4, "edgecolor": INK, "facecolor": "none", **style}
        self.paper.add_patch(Rectangle(place, *size, **style))

    def heading(self, x: float, y: float, text: str, width: float) -> float:
        """Draw a heading with a line under it; return the y of the next line."""
        self.text(x, y, text, 10, fontweight="bold")
        self.line((x, x + width), (y + 1.8, y + 1.8), 0.6, INK)
        return y + 7

    def instructions(self, y: float, lines: Iterable[str]) -> None:
        """Draw lines on how to build, in the right column; an empty one is a gap."""
        y = self.heading(self.second, y, "How to build it", COLUMN)
        for text in lines:
            self.text(self.second, y, text, 8.2)
            y += 4.4 if text else 2

    def table(self, y: float, columns: Sequence[float], rows: Iterable[Sequence[str]], **style: Any) -> float:
        """Draw rows of texts that end at the x of their columns; return the y of the next line."""
        for row in rows:
            for x, text in zip(columns, row, strict=True):
                self.text(x, y, text, ha="right", **style)
            y += ROW
        return y

    def amounts(self, x: float, y: float, rows: Iterable[tuple[str, str]]) -> float:
        """Draw lines of a text and an amount in a column; return the y of the next line."""
        for text, amount in rows:
            self.text(x, y, text)
            y = self.table(y, [x + COLUMN], [(amount,)])
        return y

    def swatch(self, x: float, y: float, colour: Colour) -> None:
        """Draw a patch of colour before a line of a table."""
        self.rectangle((x, y - 3), (6, 3.6), facecolor=colour)

    def compass(self) -> None:
        """Draw a north arrow in the upper right corner."""
        from matplotlib.patches import Polygon

        x, y = self.right - 4, 23
        for side, colour in ((-1, INK), (1, "white")):
            points = [(x, y - 6), (x + side * 2.6, y + 4), (x, y + 2)]
            self.paper.add_patch(Polygon(points, facecolor=colour, edgecolor=INK, linewidth=0.6))
        self.text(x, y - 7, "N", 9, ha="center", fontweight="bold")


EMPTY: Colour = (1.0, 1.0, 1.0)
_MARK = "#999999"
_MARKED = 0.28
"""Length of corner marks as a share of the way to the centre: long enough to see, short enough for a number."""


@dataclass(frozen=True, kw_only=True, slots=True)
class PrintedPlan:
    """A field from above on a page: its upper left corner and the side of a cell in millimetres."""

    page: Page
    scene: Scene
    field: StepField
    left: float
    top: float
    cell: float

    def middle(self, i: float, j: float) -> tuple[float, float]:
        """Return the centre of a cell on the page, frames counted."""
        return self.left + (i + 0.5) * self.cell, self.top + (self.field.shape[1] - j - 0.5) * self.cell

    def draw(self, line: float) -> None:
        """Draw the frame and the blocks, with lines of a width in points; cells without a block have marked corners."""
        from matplotlib.collections import LineCollection, PolyCollection

        if self.field.frame.any():
            # The frame is hatched boards over the whole field.
            (n_x, n_y), colour = self.field.shape, self.scene.plan_colour(0)
            place, size = (self.left, self.top), (n_x * self.cell, n_y * self.cell)
            pale = tuple(0.8 + 0.2 * part for part in colour)
            self.page.rectangle(place, size, facecolor=pale, edgecolor=colour, hatch="////", linewidth=0)
            self.page.rectangle(place, size, linewidth=0.8)
        blocks = np.nonzero(~self.field.frame)
        colours = [block_colour(self.scene, level) for level in self.field.levels[blocks].tolist()]
        squares = PolyCollection(list(self._corners(*blocks)), facecolors=colours, edgecolors=INK, linewidths=line)
        self.page.paper.add_collection(squares, autolim=False)
        # From each corner of an empty cell a line runs towards its middle.
        corners = self._corners(*np.nonzero(~self.field.frame & (self.field.levels == 0)))
        middles = corners.mean(axis=1, keepdims=True)
        marks = np.stack([corners, corners + _MARKED * (middles - corners)], axis=2).reshape(-1, 2, 2)
        self.page.paper.add_collection(LineCollection(list(marks), colors=_MARK, linewidths=line), autolim=False)

    def _corners(self, i: Ints, j: Ints) -> Array:
        """Return the corners of cells on the page in order, shape (m, 4, 2)."""
        # Upper left corners, as y of a page grows downwards; then clockwise on the page.
        x, y = self.left + i * self.cell, self.top + (self.field.shape[1] - 1 - j) * self.cell
        round_it = ((0, 0), (self.cell, 0), (self.cell, self.cell), (0, self.cell))
        return np.stack([np.stack([x + aside, y + down], axis=-1) for aside, down in round_it], axis=1)


def block_colour(scene: Scene, level: int) -> Colour:
    """Return the colour of a level on the page; white for no block."""
    return scene.plan_colour(level) if level else EMPTY
