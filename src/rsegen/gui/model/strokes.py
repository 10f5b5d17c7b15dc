"""Strokes of painting: which cells each tool paints while the mouse or the keyboard is at cells of the plan."""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum
from typing import NamedTuple

import numpy as np

from rsegen.field.stepfield import Levels
from rsegen.gui.model.painting import UNPAINTED, stroke
from rsegen.params.places import Cell


class Tool(Enum):
    """How cells are painted."""

    CELLS = "cells"
    RECTANGLE = "rectangle"
    FILL = "fill"
    PICK = "pick"


class Brush(NamedTuple):
    """A tool and the level that it paints."""

    tool: Tool
    level: int


class Painted(NamedTuple):
    """Cells, their new level (UNPAINTED to erase), and the number of the stroke."""

    cells: Sequence[Cell]
    level: int
    stroke: int


class Strokes:
    """The stroke that is being painted, if any, and the cell that the keyboard paints.

    band: the corners of the rectangle that is being drawn.
    """

    def __init__(self) -> None:
        self.cursor: Cell = (0, 0)
        self.band: tuple[Cell, Cell] | None = None
        self._level: int | None = None
        self._tool = Tool.CELLS
        self._count = 0

    @property
    def is_going_on(self) -> bool:
        """Whether the mouse is painting."""
        return self._level is not None

    def begin(self, brush: Brush, cell: Cell, levels: Levels, *, erases: bool) -> Painted | None:
        """Start a stroke at a cell; gives what it paints at once. `levels`: those of all blocks, for filling."""
        self._tool, self._level = brush.tool, UNPAINTED if erases else brush.level
        self._count += 1
        self.cursor = cell
        if brush.tool is Tool.RECTANGLE:
            self.band = cell, cell
            return None
        return self._painted(connected(levels, cell) if brush.tool is Tool.FILL else (cell,))

    def go_to(self, cell: Cell) -> Painted | None:
        """Continue the stroke to another cell; gives what that paints, without a gap."""
        if self._level is None or cell == self.cursor:
            return None
        before, self.cursor = self.cursor, cell
        if self.band:
            self.band = self.band[0], cell
        return self._painted(stroke(before, cell)) if self._tool is Tool.CELLS else None

    def end(self) -> Painted | None:
        """End the stroke; gives what that paints: a rectangle."""
        found = self._painted(rectangle(*self.band)) if self.band else None
        self.cancel()
        return found

    def cancel(self) -> None:
        """End the stroke without painting more."""
        self._level = self.band = None

    def paint_here(self, level: int) -> Painted:
        """Give the cell of the keyboard a level, as a stroke of its own."""
        self._count += 1
        return Painted((self.cursor,), level, self._count)

    def _painted(self, cells: Sequence[Cell]) -> Painted | None:
        return None if self._level is None else Painted(tuple(cells), self._level, self._count)


def rectangle(one: Cell, other: Cell) -> tuple[Cell, ...]:
    """All cells between two corners, both included."""
    (x1, x2), (y1, y2) = (sorted(pair) for pair in zip(one, other, strict=True))
    return tuple((x, y) for x in range(x1, x2 + 1) for y in range(y1, y2 + 1))


def connected(levels: Levels, start: Cell) -> tuple[Cell, ...]:
    """The cells of the level of one that it is connected with by sides, itself included."""
    free = np.pad(levels == levels[start], 1)
    free[start[0] + 1, start[1] + 1] = False
    found, edge = [start], [start]
    while edge:
        x, y = edge.pop()
        for at in ((x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)):
            if free[at[0] + 1, at[1] + 1]:
                free[at[0] + 1, at[1] + 1] = False
                found.append(at)
                edge.append(at)
    return tuple(found)
