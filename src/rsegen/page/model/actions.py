"""The actions by which pages change a recipe: functions of this file, and methods of a session, called by their names.

    {"do": "move_end", "row": 2, "end": "last", "cell": [4, 9], "gesture": "g7"} --> a change of the session

Each returns the row that it was about, which a page then selects: -1 if none. Cells are of the map that the page shows;
those that are painted by hand become a matrix obstacle. Changes of one gesture, such as a drag, are undone together: a
page gives each another name.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Annotated, Any, Literal, TypedDict, cast

import numpy as np

from rsegen.errors import ParameterError, UnknownName, UserError, inside, shown
from rsegen.field.stepfield import Ints, Mask
from rsegen.obstacles import Obstacle
from rsegen.obstacles.matrix import Matrix
from rsegen.page.calls import checked_arguments
from rsegen.page.model.session import Entry, Session
from rsegen.params.sorts import MOST_LEVELS, Cell, Json
from rsegen.params.streams import generator
from rsegen.recipe.codec import MOST_OBSTACLES, decode_obstacle
from rsegen.recipe.map_design import MapDesign

Action = Annotated[Mapping[str, Json], "Action"]

_OF_SESSION: Mapping[str, Callable[..., None]] = {
    name: getattr(Session, name)
    for name in ("set", "change", "remove", "move", "enable", "clear", "reroll", "undo", "redo")
}
"""The actions that are methods of a session, by their names."""

_ACTIONS: dict[str, Callable[..., Any]] = {**_OF_SESSION}


def actions() -> Mapping[str, Callable[..., Any]]:
    """Return the functions and methods that pages have called as actions, by their names."""
    return _ACTIONS


UNPAINTED = -1
"""The level that erases a cell."""


def act(session: Session, actions: Sequence[Action], index: int) -> int:
    """Apply actions, all or none of them, on a page that shows map `index`; return the row that the last was about."""
    selected = -1
    with session.all_or_nothing(), session.together():
        for position, action in enumerate(actions):
            with inside(f"actions[{position}]"):
                selected = _apply(session, action, index)
    return min(selected, len(session.draft.rows) - 1)


def _apply(session: Session, action: Action, index: int) -> int:
    if not isinstance(action, dict):
        raise ParameterError("", f"{shown(action)} is not an action")
    arguments = dict(action)
    name = arguments.pop("do", None)
    if not isinstance(name, str) or name not in _ACTIONS:
        raise UnknownName.among("do", "action", name, _ACTIONS)
    known = checked_arguments(_ACTIONS[name], arguments)
    for where in ("row", "to"):
        if where in known and not (name == "paint" and known["row"] == -1):
            _check_row(session, where, known[where])
    if name not in _OF_SESSION:
        return int(_ACTIONS[name](session, index, **known))
    _OF_SESSION[name](session, **known)
    return int(known.get("to", known.get("row", -1)))


def _check_row(session: Session, where: str, row: int, extra: int = 0) -> None:
    """Raise a ParameterError for a row that is not in the list, of which another page may have removed it."""
    rows = len(session.draft.rows) + extra
    if not 0 <= row < rows:
        raise ParameterError(where, f"{row} is outside 0..{rows - 1}" if rows else f"{row}: the list is empty")


def _check_cells(session: Session, where: str, cells: list[Cell]) -> None:
    shape = session.design.grid.shape
    for cell in cells:
        if not all(0 <= at < most for at, most in zip(cell, shape, strict=True)):
            raise ParameterError(where, f"{shown(list(cell))} is outside the map of {shape[0]} x {shape[1]} blocks")


def _action(function: Callable[..., int]) -> Callable[..., int]:
    """Let pages do what a function does, by its name."""
    _ACTIONS[function.__name__] = function
    return function


@_action
def add(session: Session, _index: int, *, entry: Entry, at: int | None = None) -> int:
    """Add an obstacle, in line where its kind must be axis-aligned."""
    if len(session.draft.rows) >= MOST_OBSTACLES:
        raise UserError(f"the list has {MOST_OBSTACLES:,} obstacles, the most that a recipe can have")
    if at is not None:
        _check_row(session, "at", at, 1)
    return session.add(aligned(entry, "last"), at)


@_action
def duplicate(session: Session, _index: int, *, row: int) -> int:
    """Copy a row to the row below it."""
    return add(session, 0, entry=dict(session.draft.rows[row]), at=row + 1)


@_action
def fix(session: Session, _index: int, *, row: int, index: int) -> int:
    """Make random ends the cells where they are in a map."""
    session.change(row=row, entry=fixed(session.keyed_row(row), session.design, index))
    return row


@_action
def move_end(session: Session, index: int, *, row: int, end: End, cell: Cell, gesture: str | None = None) -> int:
    """Move an end of an obstacle, or both, to a cell; random ends are fixed where they are in the map shown."""
    _check_cells(session, "cell", [cell])
    entry = with_end_at(session.keyed_row(row), end, cell, session.design, index)
    session.change(row=row, entry=entry, gesture=gesture)
    return row


@_action
def paint(session: Session, _index: int, *, row: int, cells: list[Cell], level: int, gesture: str | None = None) -> int:
    """Give cells a level, in a matrix or, if the row is none that can be painted into, in a new one."""
    _check_cells(session, "cells", cells)
    if not UNPAINTED <= level < MOST_LEVELS:
        raise ParameterError("level", f"{level} is outside {UNPAINTED}..{MOST_LEVELS - 1}")
    entry = session.draft.rows[row] if row >= 0 else None
    if entry is not None and can_paint(entry):
        if cells:
            session.change(row=row, entry=painted(entry, cells, level), gesture=gesture)
        return row
    if level == UNPAINTED or not cells:
        return row
    return session.add(painted(None, cells, level), gesture=gesture)


def can_paint(entry: Entry) -> bool:
    """Return whether an entry is a matrix in its own size at a fixed place, so that cells can be painted into it."""
    try:
        matrix = decode_obstacle(entry)
    except ParameterError:
        return False
    if not isinstance(matrix, Matrix) or matrix.softness or "random" in (matrix.first or ()):
        return False
    start = matrix.first or (0, 0)
    own = tuple(at + size - 1 for at, size in zip(start, matrix.size, strict=True))  # type: ignore[operator]  # a cell
    return matrix.last in (None, own)


def painted(entry: Entry | None, cells: Sequence[Cell], level: int) -> dict[str, Json]:
    """Return a matrix entry, or a new one, with some cells set to a level; it grows as needed."""
    start, levels = _grown(entry, cells)
    for x, y in cells:
        levels[x - start[0], y - start[1]] = level
    (x1, x2), (y1, y2) = (_span(levels >= 0, axis) for axis in (0, 1))  # it shrinks too, if cells are erased
    matrix = Matrix.of(levels[x1:x2, y1:y2])
    first = start[0] + x1, start[1] + y1
    return {
        **(entry or {"kind": Matrix.kind}),
        "levels": max(matrix.levels, entry.get("levels", 2) if entry else 2),
        "rows": list(matrix.rows),
        "first": list(first),
        "last": [at + size - 1 for at, size in zip(first, matrix.size, strict=True)],
    }


def _grown(entry: Entry | None, cells: Sequence[Cell]) -> tuple[Cell, Ints]:
    """Return the corner of smallest x and y, and the levels from there on, of the entry grown to include the cells."""
    corners = [*cells]
    if entry:
        old = decode_obstacle(entry)
        levels = old.cell_levels()  # type: ignore[attr-defined]  # a matrix
        x, y = entry.get("first", (0, 0))
        corners += [(x, y), (x + levels.shape[0] - 1, y + levels.shape[1] - 1)]
    low, high = np.min(corners, axis=0), np.max(corners, axis=0)
    grown = np.full(high - low + 1, UNPAINTED)
    if entry:
        grown[x - low[0] : x - low[0] + levels.shape[0], y - low[1] : y - low[1] + levels.shape[1]] = levels
    return (int(low[0]), int(low[1])), grown


def _span(covered: Mask, axis: int) -> tuple[int, int]:
    """Return the range of painted cells along an axis; the first cell if none is painted."""
    painted_lines = np.flatnonzero(covered.any(axis=1 - axis))
    return (int(painted_lines[0]), int(painted_lines[-1]) + 1) if len(painted_lines) else (0, 1)


End = Literal["first", "last", "both"]
"""End of an obstacle that is moved; both: its middle, and the two ends with it."""


class Ends(TypedDict):
    """The two ends of an obstacle, each a list in a file."""

    first: Cell
    last: Cell


def ends_of(entry: Entry, design: MapDesign, index: int) -> Ends | None:
    """Return where an obstacle lies in map `index`, first and last, also if that is random; None if it does not fit."""
    obstacle = _obstacle(entry)
    if obstacle is None:
        return None
    try:
        obstacle.check_size(design.grid)
        drawn = generator(design.seed, index, obstacle.key or "")
        ends = obstacle.ends(design.grid, *obstacle.wanted_ends(design.grid), drawn)
    except ParameterError:
        return None
    on_map = all(0 <= at < cells for end in ends for at, cells in zip(end, design.grid.shape, strict=True))
    first, last = (cast(Cell, list(end)) for end in ends)
    return {"first": first, "last": last} if on_map else None


def fixed(entry: Entry, design: MapDesign, index: int) -> Entry:
    """Return an entry with both ends fixed where they are in map `index`, for instance where they were drawn at random.

    The entry as it is if it is invalid, or does not fit into the map.
    """
    return {**entry, **(ends_of(entry, design, index) or {})}


def with_end_at(entry: Entry, end: End, cell: Cell, design: MapDesign, index: int) -> Entry:
    """Return an entry with an end moved to a cell, or both with their middle, as far as the map reaches.

    The other end stays where it is in map `index`, in line with the moved one if the kind must be axis-aligned.
    """
    placed = fixed(entry, design, index)
    if end != "both":
        return aligned({**placed, end: list(cell)}, "last" if end == "first" else "first")
    ends = _cell(placed.get("first")), _cell(placed.get("last"))
    if not all(ends):
        return entry
    # The step of the middle to the cell, cut so that both ends stay on the map.
    by = [
        min(max(to - sum(pair) // 2, -min(pair)), cells - 1 - max(pair))
        for to, pair, cells in zip(cell, zip(*ends, strict=True), design.grid.shape, strict=True)
    ]
    first, last = ([at + step for at, step in zip(place, by, strict=True)] for place in ends)
    return {**placed, "first": first, "last": last}


def aligned(entry: Entry, end: str) -> Entry:
    """Return an entry with one end moved in line with the other if its kind must be axis-aligned, else as it is."""
    ends = [_cell(entry.get(name)) for name in (end, "last" if end == "first" else "first")]
    # Ends in line are the only thing that makes it valid: then its kind must be axis-aligned.
    if _obstacle(entry) or not all(ends):
        return entry
    (x, y), (other_x, other_y) = ends
    in_line = {**entry, end: [x, other_y] if abs(x - other_x) >= abs(y - other_y) else [other_x, y]}
    return in_line if _obstacle(in_line) else entry


def _obstacle(entry: Entry) -> Obstacle | None:
    """Return the obstacle of an entry; None if it is invalid."""
    try:
        return decode_obstacle(entry)
    except ParameterError:
        return None


def _cell(place: Json) -> tuple[int, ...]:
    """Return a place of two numbers; empty for any other, such as a random one."""
    known = isinstance(place, (list, tuple)) and len(place) == 2 and all(isinstance(at, int) for at in place)
    return tuple(place) if known else ()
