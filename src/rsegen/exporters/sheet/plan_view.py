"""Plan views on a page, north up: cells in the colours of their levels, frames hatched."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rsegen.exporters.scene import Colour, Scene
from rsegen.exporters.sheet.page import GREY, INK, Page
from rsegen.field.stepfield import Array, Ints, StepField

EMPTY: Colour = (1.0, 1.0, 1.0)
_MARK = "#999999"
_MARKED = 0.28
"""The length of corner marks as a share of the way to the centre."""


@dataclass(frozen=True, kw_only=True, slots=True)
class PlanView:
    """A field from above on a page: its upper left corner and the side of a cell in millimetres."""

    page: Page
    scene: Scene
    field: StepField
    left: float
    top: float
    cell: float

    def middle(self, i: float, j: float) -> tuple[float, float]:
        """The centre of a cell on the page, frames counted."""
        return self.left + (i + 0.5) * self.cell, self.top + (self.field.shape[1] - j - 0.5) * self.cell

    def draw(self, line: float) -> None:
        """Draw the frame and the blocks, with lines of a width in points; cells without a block have marked corners."""
        from matplotlib.collections import LineCollection, PolyCollection

        if self.field.frame.any():
            self._draw_frame()
        blocks = np.nonzero(~self.field.frame)
        colours = [block_colour(self.scene, level) for level in self.field.levels[blocks].tolist()]
        squares = PolyCollection(list(self._corners(*blocks)), facecolors=colours, edgecolors=INK, linewidths=line)
        self.page.paper.add_collection(squares, autolim=False)
        corners = self._corners(*np.nonzero(~self.field.frame & (self.field.levels == 0)))
        middles = corners.mean(axis=1, keepdims=True)
        marks = np.stack([corners, corners + _MARKED * (middles - corners)], axis=2).reshape(-1, 2, 2)
        self.page.paper.add_collection(LineCollection(list(marks), colors=_MARK, linewidths=line), autolim=False)

    def _draw_frame(self) -> None:
        """Draw the frame as hatched boards over the whole field."""
        n_x, n_y = self.field.shape
        colour = self.scene.colour(0)
        size = n_x * self.cell, n_y * self.cell
        pale = tuple(0.8 + 0.2 * part for part in colour)
        self.page.rectangle((self.left, self.top), size, facecolor=pale, edgecolor=colour, hatch="////", linewidth=0)
        self.page.rectangle((self.left, self.top), size, linewidth=0.8)

    def _corners(self, i: Ints, j: Ints) -> Array:
        """The corners of cells on the page in order, shape (m, 4, 2)."""
        x, y = self.left + i * self.cell, self.top + (self.field.shape[1] - 1 - j) * self.cell
        round_it = ((0, 0), (self.cell, 0), (self.cell, self.cell), (0, self.cell))
        return np.stack([np.stack([x + aside, y + down], axis=-1) for aside, down in round_it], axis=1)


def draw_run(page: Page, ends: tuple[float, float], y: float) -> None:
    """Draw where a run starts, in the west, and its goal, in the east, beside a plan between two x on the page."""
    for x, text in ((ends[0] - 3, "start"), (ends[1] + 3, "goal")):
        page.text(x, y, text, 8, ha="center", va="center", rotation=90, color=GREY)
        page.text(x, y - 7, "\N{RIGHTWARDS ARROW}", 9, ha="center", va="center", color=GREY)


def block_colour(scene: Scene, level: int) -> Colour:
    """The colour of a level on the page; white for no block."""
    return scene.colour(level) if level else EMPTY


def ink(colour: Colour) -> str:
    """The text colour that is legible on a colour, in greyscale print too."""
    red, green, blue = colour
    return "white" if 0.3 * red + 0.59 * green + 0.11 * blue < 0.5 else "black"
