"""An A4 page with positions in millimetres from the upper left corner."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from rsegen.exporters.scene import Colour

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH, HEIGHT, MARGIN = 210.0, 297.0, 15.0
INCH = 25.4
POINT = INCH / 72
"""A typographic point in millimetres."""

INK, GREY, PALE = "#1a1a1a", "#666666", "#bbbbbb"
ROW = 5.2
"""The line height of tables in millimetres."""


class Page:
    """An A4 page of vector graphics; `across` is the width between its margins."""

    left, right, bottom = MARGIN, WIDTH - MARGIN, HEIGHT - MARGIN
    across = WIDTH - 2 * MARGIN

    def __init__(self) -> None:
        from matplotlib.figure import Figure

        self.figure: Figure = Figure(figsize=(WIDTH / INCH, HEIGHT / INCH), dpi=100)
        self.paper = self.figure.add_axes((0, 0, 1, 1))
        self.paper.set(xlim=(0, WIDTH), ylim=(HEIGHT, 0))
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
        width = TextPath((0, 0), plain, prop=font).get_extents().width if plain.strip() else 0.0
        self.text(*place, known, size * min(1.0, room / POINT / max(width, 1)), **style)

    def line(self, xs: Sequence[float], ys: Sequence[float], width: float = 0.4, colour: str = PALE) -> None:
        """Draw a line through points; its width is in points."""
        self.paper.plot(xs, ys, color=colour, linewidth=width, solid_capstyle="butt")

    def rectangle(self, place: tuple[float, float], size: tuple[float, float], **style: Any) -> None:
        """Draw a rectangle from its upper left corner."""
        from matplotlib.patches import Rectangle

        self.paper.add_patch(
            Rectangle(place, *size, **{"linewidth": 0.4, "edgecolor": INK, "facecolor": "none", **style})
        )

    def heading(self, x: float, y: float, text: str, width: float) -> float:
        """Draw a heading with a line under it; returns the y of the next line."""
        self.text(x, y, text, 10, fontweight="bold")
        self.line((x, x + width), (y + 1.8, y + 1.8), 0.6, INK)
        return y + 7

    def table(self, y: float, columns: Sequence[float], rows: Iterable[Sequence[str]], **style: Any) -> float:
        """Draw rows of texts that end at the x of their columns; returns the y of the next line."""
        for row in rows:
            for x, text in zip(columns, row, strict=True):
                self.text(x, y, text, ha="right", **style)
            y += ROW
        return y

    def swatch(self, x: float, y: float, colour: Colour) -> None:
        """Draw a patch of colour before a line of a table."""
        self.rectangle((x, y - 3), (6, 3.6), facecolor=colour)

    def compass(self, x: float, y: float) -> None:
        """Draw a north arrow with its centre at x, y."""
        from matplotlib.patches import Polygon

        for side, colour in ((-1, INK), (1, "white")):
            points = [(x, y - 6), (x + side * 2.6, y + 4), (x, y + 2)]
            self.paper.add_patch(Polygon(points, facecolor=colour, edgecolor=INK, linewidth=0.6))
        self.text(x, y - 7, "N", 9, ha="center", fontweight="bold")
