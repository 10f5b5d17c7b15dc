"""The ends of obstacles: where they lie in a map, and how they are moved."""

from __future__ import annotations

from typing import Literal

from rsegen.errors import ParameterError
from rsegen.field.obstacles import Obstacle
from rsegen.page.model.session import Entry
from rsegen.params.sorts import Cell, Json
from rsegen.params.streams import generator
from rsegen.recipe.building import ends_by
from rsegen.recipe.codec import decode_obstacle
from rsegen.recipe.map_design import MapDesign

End = Literal["first", "last", "both"]
"""Which end is moved; both: the middle of the two, and them with it."""


def ends_of(entry: Entry, design: MapDesign, index: int) -> Entry | None:
    """Return where an obstacle lies in map `index`, first and last, also if that is random; None if it does not fit."""
    obstacle = _obstacle(entry)
    if obstacle is None:
        return None
    try:
        obstacle.check_size(design.grid)
        ends = ends_by(design.grid, obstacle, generator(design.seed, index, obstacle.key or ""))
    except ParameterError:
        return None
    on_map = all(0 <= at < cells for end in ends for at, cells in zip(end, design.grid.shape, strict=True))
    return dict(zip(("first", "last"), map(list, ends), strict=True)) if on_map else None


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
    by = [
        min(max(to - sum(pair) // 2, -min(pair)), cells - 1 - max(pair))
        for to, pair, cells in zip(cell, zip(*ends, strict=True), design.grid.shape, strict=True)
    ]
    first, last = ([at + step for at, step in zip(place, by, strict=True)] for place in ends)
    return {**placed, "first": first, "last": last}


def aligned(entry: Entry, end: str) -> Entry:
    """Return an entry with one end moved in line with the other if its kind must be axis-aligned, else as it is."""
    ends = [_cell(entry.get(name)) for name in (end, "last" if end == "first" else "first")]
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
