"""The ends of obstacles as they are shown on a plan, and taken hold of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

from rsegen.gui.cells import Layout, Point
from rsegen.places import Cell

End = Literal["first", "last"]
ENDS: tuple[End, End] = ("first", "last")

GRIP = 7.0
"""Half a handle, in pixels."""

_REACH = 11.0
"""A handle is taken hold of from so many pixels away, in x and in y."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Handle:
    """Row `row` of a recipe's obstacles, and its ends in block cells; none where they are drawn or not given."""

    row: int
    first: Cell | None = None
    last: Cell | None = None

    def end(self, end: End) -> Cell | None:
        """One of its ends."""
        return self.first if end == "first" else self.last


class Grip(NamedTuple):
    """One end of one obstacle."""

    row: int
    end: End


def grip_at(handles: Sequence[Handle], selected: int | None, layout: Layout, point: Point) -> Grip | None:
    """The handle under a point: the selected obstacle's before the others', the last end before the first."""
    in_order = sorted(handles, key=lambda handle: handle.row != selected)
    for handle in in_order:
        for end in reversed(ENDS):
            cell = handle.end(end)
            if cell and all(abs(a - b) <= _REACH for a, b in zip(layout.middle(cell), point, strict=True)):
                return Grip(handle.row, end)
    return None


def cell_of(handles: Sequence[Handle], grip: Grip) -> Cell | None:
    """Where an end lies, none where it lies nowhere or there is no such row."""
    return next((handle.end(grip.end) for handle in handles if handle.row == grip.row), None)


def moved(handles: Sequence[Handle], grip: Grip, cell: Cell) -> tuple[Handle, ...]:
    """The handles with one end elsewhere."""
    return tuple(_with(handle, grip.end, cell) if handle.row == grip.row else handle for handle in handles)


def _with(handle: Handle, end: End, cell: Cell) -> Handle:
    return replace(handle, first=cell) if end == "first" else replace(handle, last=cell)
