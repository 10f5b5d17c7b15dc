"""The ends of obstacles on the plan, as handles that the mouse can drag."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np

from rsegen.field.stepfield import CellWindow, StepField
from rsegen.gui.model.plan_layout import PlanLayout, Point
from rsegen.gui.model.session import ObstacleRow
from rsegen.params.places import Cell
from rsegen.params.sorts import Json

End = Literal["first", "last", "both"]
"""What a handle moves."""

ENDS: tuple[End, End] = ("first", "last")

GRIP = 7.0
"""Half a handle, in pixels."""

_REACH = 11.0
"""A handle is hit within this many pixels, in x and in y."""

_ROOM = 4.5 * GRIP
"""Pixels between two ends that leave room for a third handle."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Handle:
    """The ends of the obstacle in row `row`, in block cells; None for random or missing ends."""

    row: int
    first: Cell | None = None
    last: Cell | None = None

    def end(self, end: End) -> Cell | None:
        """One of its ends, or the cell in the middle of both."""
        if end != "both":
            return self.first if end == "first" else self.last
        if self.first is None or self.last is None:
            return None
        return (self.first[0] + self.last[0]) // 2, (self.first[1] + self.last[1]) // 2

    def shows_middle(self, layout: PlanLayout) -> bool:
        """Whether there is room between its ends for a handle that moves both."""
        if self.first is None or self.last is None:
            return False
        (x1, y1), (x2, y2) = layout.middle(self.first), layout.middle(self.last)
        return max(abs(x1 - x2), abs(y1 - y2)) > _ROOM


def handles_of(rows: Sequence[ObstacleRow], shape: Cell) -> list[Handle]:
    """The handles of the rows that are switched on; an end that is random or outside the map is None."""
    return [
        Handle(row=number, first=_place(row.entry.get("first"), shape), last=_place(row.entry.get("last"), shape))
        for number, row in enumerate(rows)
        if row.enabled
    ]


def cells_between(handle: Handle, field: StepField) -> CellWindow | None:
    """The field cells between the ends of an obstacle, frames included; None if an end is missing."""
    if handle.first is None or handle.last is None:
        return None
    x, y = (
        np.flatnonzero(field.inside(axis))[sorted((handle.first[axis], handle.last[axis]))].tolist() for axis in (0, 1)
    )
    return slice(x[0], x[1] + 1), slice(y[0], y[1] + 1)


class Grip(NamedTuple):
    """One end of one obstacle, or both."""

    row: int
    end: End


def grip_at(handles: Sequence[Handle], selected: int | None, layout: PlanLayout, point: Point) -> Grip | None:
    """The handle under a point; of several the selected obstacle's, and the last end before the first.

    Only the selected obstacle has one in the middle, which moves it as a whole.
    """
    in_order = sorted(handles, key=lambda handle: handle.row != selected)
    for handle in in_order:
        has_middle = handle.row == selected and handle.shows_middle(layout)
        for end in (*reversed(ENDS), *(("both",) if has_middle else ())):
            cell = handle.end(end)
            if cell and all(abs(a - b) <= _REACH for a, b in zip(layout.middle(cell), point, strict=True)):
                return Grip(handle.row, end)
    return None


def cell_of(handles: Sequence[Handle], grip: Grip) -> Cell | None:
    """The cell of an end; None if it has none or there is no such row."""
    return next((handle.end(grip.end) for handle in handles if handle.row == grip.row), None)


def moved(handles: Sequence[Handle], grip: Grip, cell: Cell, shape: Cell) -> tuple[Handle, ...]:
    """The handles with one end, or the middle of both, moved to a cell of a map of this many cells."""
    return tuple(_with(handle, grip.end, cell, shape) if handle.row == grip.row else handle for handle in handles)


def _place(value: Json, shape: Cell) -> Cell | None:
    known = isinstance(value, (list, tuple)) and len(value) == 2 and all(isinstance(at, int) for at in value)
    x, y = value if known else (-1, -1)
    return (x, y) if 0 <= x < shape[0] and 0 <= y < shape[1] else None


def _with(handle: Handle, end: End, cell: Cell, shape: Cell) -> Handle:
    if end != "both":
        return replace(handle, first=cell) if end == "first" else replace(handle, last=cell)
    first, last, middle = handle.first, handle.last, handle.end("both")
    if first is None or last is None or middle is None:
        return handle
    by = [
        min(max(to - at, -min(ends)), cells - 1 - max(ends))
        for to, at, ends, cells in zip(cell, middle, zip(first, last, strict=True), shape, strict=True)
    ]
    return replace(handle, first=(first[0] + by[0], first[1] + by[1]), last=(last[0] + by[0], last[1] + by[1]))
