"""The ends of obstacles, as handles on the plan and as cells of the list; the obstacle before it is added."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np

from rsegen.errors import ParameterError
from rsegen.exporters.scene import Scene
from rsegen.field.obstacles import KINDS, Obstacle
from rsegen.field.obstacles.base import row_parameters
from rsegen.field.stepfield import CellWindow, Mask, StepField
from rsegen.gui.model.plan_layout import PlanLayout, Point
from rsegen.gui.model.session import Entry, ObstacleRow
from rsegen.params.sorts import Cell, CellRef, Float, Json, Parameter, parameters
from rsegen.params.streams import generator
from rsegen.recipe.building import ends_by, impose, placed
from rsegen.recipe.codec import decode_obstacle
from rsegen.recipe.recipe import Recipe


def aligned(entry: Entry, end: str) -> Entry:
    """An entry with one end moved in line with the other if its kind must be axis-aligned; else the entry as it is."""
    ends = [_cell(entry.get(name)) for name in (end, other_end(end))]
    if _obstacle(entry) or not all(ends):
        return entry
    (x, y), (other_x, other_y) = ends
    in_line = {**entry, end: [x, other_y] if abs(x - other_x) >= abs(y - other_y) else [other_x, y]}
    return in_line if _obstacle(in_line) else entry


def shifted(before: Entry, entry: Entry, end: str) -> Entry:
    """An entry one of whose ends was set to another place; an axis-aligned one keeps its direction if it has one.

    So a barrier along y whose X first is set moves along x as a whole. Of others, the other end is moved in line.
    """
    was, is_, other = _cell(before.get(end)), _cell(entry.get(end)), _cell(entry.get(other_end(end)))
    if not _obstacle(entry) and was and is_ and other:
        axis = int(was[0] == is_[0])
        if was[axis] == other[axis] and was[1 - axis] != other[1 - axis]:
            place = [is_[0], other[1]] if axis == 0 else [other[0], is_[1]]
            moved = {**entry, other_end(end): place}
            if _obstacle(moved):
                return moved
    return aligned(entry, other_end(end))


def other_end(end: str) -> str:
    """The last end for the first, and the first for any other."""
    return "last" if end == "first" else "first"


def fixed(entry: Entry, recipe: Recipe, index: int) -> Entry:
    """An entry with both ends fixed where they are in map `index`, for instance where they were drawn at random.

    The entry as it is if it is invalid, or does not fit into the map.
    """
    obstacle = _obstacle(entry)
    if not obstacle:
        return entry
    try:
        obstacle.check_size(recipe.grid)
    except ParameterError:
        return entry
    first, last = ends_by(recipe.grid, obstacle, generator(recipe.seed, index, obstacle.key or ""))
    return {**entry, "first": list(first), "last": list(last)}


def _obstacle(entry: Entry) -> Obstacle | None:
    """The obstacle of an entry; None if it is invalid."""
    try:
        return decode_obstacle(entry)
    except ParameterError:
        return None


def _cell(place: Json) -> tuple[int, ...]:
    """A place of two numbers; empty for any other, such as a random one."""
    known = isinstance(place, (list, tuple)) and len(place) == 2 and all(isinstance(at, int) for at in place)
    return tuple(place) if known else ()


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
        """An end of it, or the cell in the middle of both."""
        if end != "both":
            return self.first if end == "first" else self.last
        if self.first is None or self.last is None:
            return None
        return (self.first[0] + self.last[0]) // 2, (self.first[1] + self.last[1]) // 2

    def shows_middle(self, layout: PlanLayout) -> bool:
        """Return whether there is room between its ends for a handle that moves both."""
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
    """An end of one obstacle, or both."""

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


@dataclass(frozen=True, kw_only=True, slots=True)
class Ghost:
    """scene: the map with the blocks of this obstacle alone; cells: (n_x, n_y), the field cells that it covers."""

    scene: Scene
    cells: Mask


def ghost_of(scene: Scene, entry: Entry) -> Ghost | None:
    """Another obstacle in a map, where it would lie if it were added; None if it is invalid.

    What constraints and difficulty would make of it is left out.
    """
    try:
        recipe = replace(scene.recipe, obstacles=(*scene.recipe.obstacles, decode_obstacle(entry)))
        *_, patch = placed(recipe, recipe.obstacles[-1], scene.index)
    except ParameterError:
        return None
    field = scene.field
    blocks = field.blocks
    impose(blocks, patch, recipe.obstacles[-1].blend, recipe.top_level)
    inside = np.ix_(field.inside(0), field.inside(1))
    covered = np.zeros(blocks.shape, dtype=bool)
    covered[patch.window] = patch.footprint
    cells, levels = np.zeros(field.shape, dtype=bool), np.zeros(field.shape, dtype=np.int16)
    cells[inside], levels[inside] = covered, np.where(covered, blocks, 0)
    alone = replace(field, levels=levels, frame=np.zeros_like(field.frame))
    return Ghost(scene=replace(scene, recipe=recipe, field=alone), cells=cells)


TITLES = {"kind": "type"}
"""What the window calls parameters whose name says less."""


def kind_words(kind: str) -> str:
    """The name of a kind in plain words: diagonal barrier."""
    return kind.replace("_", " ")


_DEFAULTS = {"softness": 0}
"""What is shown of keys that a recipe may leave out."""


def cell_text(entry: Entry, key: str) -> str:
    """A value of an entry as the text of a cell, kinds in plain words; empty for one that is missing, of no default."""
    value = entry.get(key, _DEFAULTS.get(key))
    if value is None:
        return ""
    if isinstance(value, str) and value in KINDS:
        return kind_words(value)
    if isinstance(value, float):
        return f"{value:g}"
    return ", ".join(map(str, value)) if isinstance(value, (list, tuple)) else str(value)


def with_typed(entry: Entry, key: str, text: str) -> Entry:
    """An entry after a text was typed into the cell of a key; an empty text removes the value.

    What is typed may be invalid: the draft then says so. Another kind takes over the parameters that it has too.
    """
    text = text.strip()
    if key == "kind":
        return _with_kind(entry, next((kind for kind in KINDS if text in {kind, kind_words(kind)}), text))
    rest = {name: value for name, value in entry.items() if name != key}
    return {**rest, key: _parsed(entry["kind"], key, text)} if text else rest


def wrong_cell(problem: ParameterError | None) -> tuple[int, str]:
    """The row and the key that a problem is about: -1 if it is about no row, an empty key if about the whole row."""
    head, _, rest = (problem.where if problem else "").partition("obstacles[")
    number, closing, after = rest.partition("]")
    if head or not closing or not number.isdigit():
        return -1, ""
    key = after.removeprefix(".").partition("[")[0]
    return int(number), key


def problem_text(problem: ParameterError | None) -> str:
    """A problem as the window says it: `Row 4, X first: 99 is outside 0..29`; empty if there is none."""
    if problem is None:
        return ""
    row, key = wrong_cell(problem)
    return f"Row {row + 1}, {_words(key, problem.where)}: {problem.problem}" if row >= 0 else str(problem)


def _words(key: str, where: str) -> str:
    """A parameter of an obstacle in plain words: X first for `obstacles[0].first[0]`."""
    axis = {"[0]": "X ", "[1]": "Y "}.get(where[-3:], "") if key in {"first", "last"} else ""
    number = where[where.rindex("[") :] if key and not axis and where.endswith("]") and "." in where else ""
    return f"{axis}{TITLES.get(key, key).replace('_', ' ')}{number}" if key else "the obstacle"


def _with_kind(entry: Entry, kind: str) -> Entry:
    known = row_parameters(KINDS[kind]) if kind in KINDS else entry
    return {"kind": kind} | {name: value for name, value in entry.items() if name != "kind" and name in known}


def typed_value(parameter: Parameter, text: str) -> object:
    """The value of a text as on the command line, unchecked; a comma in a number that is no list is a decimal mark."""
    number = parameter.parse(text.replace(",", ".")) if isinstance(parameter, Float) else text
    return number if isinstance(number, float) else parameter.parse(text)


def _parsed(kind: str, key: str, text: str) -> Json:
    """The value of a text; a place may be in brackets, as messages write it. The kind may be unknown."""
    sort = parameters(KINDS.get(kind, Obstacle))[key]
    found = typed_value(sort, text.replace(" ", "").strip("[]") if isinstance(sort, CellRef) else text)
    return list(found) if isinstance(found, tuple) else found
