"""The two ends of an obstacle: straightened when the user moves one, and fixed where they were drawn."""

from __future__ import annotations

from rsegen.errors import ParameterError
from rsegen.gui.model.session import Entry
from rsegen.params.sorts import Json
from rsegen.params.streams import generator
from rsegen.recipe.building import ends_by
from rsegen.recipe.codec import decode_placement
from rsegen.recipe.placement import Placement
from rsegen.recipe.recipe import Recipe


def aligned(entry: Entry, end: str) -> Entry:
    """An entry with one end moved in line with the other if its kind must be axis-aligned; else the entry as it is."""
    ends = [_cell(entry.get(name)) for name in (end, other_end(end))]
    if _placement(entry) or not all(ends):
        return entry
    (x, y), (other_x, other_y) = ends
    in_line = {**entry, end: [x, other_y] if abs(x - other_x) >= abs(y - other_y) else [other_x, y]}
    return in_line if _placement(in_line) else entry


def shifted(before: Entry, entry: Entry, end: str) -> Entry:
    """An entry one of whose ends was set to another place; an axis-aligned one keeps its direction if it has one.

    So a barrier along y whose X first is set moves along x as a whole. Of others, the other end is moved in line.
    """
    was, is_, other = _cell(before.get(end)), _cell(entry.get(end)), _cell(entry.get(other_end(end)))
    if not _placement(entry) and was and is_ and other:
        axis = int(was[0] == is_[0])
        if was[axis] == other[axis] and was[1 - axis] != other[1 - axis]:
            place = [is_[0], other[1]] if axis == 0 else [other[0], is_[1]]
            moved = {**entry, other_end(end): place}
            if _placement(moved):
                return moved
    return aligned(entry, other_end(end))


def other_end(end: str) -> str:
    """The last end for the first, and the first for any other."""
    return "last" if end == "first" else "first"


def fixed(entry: Entry, recipe: Recipe, index: int) -> Entry:
    """An entry with both ends fixed where they are in map `index`, for instance where they were drawn at random.

    The entry as it is if it is invalid, or does not fit into the map.
    """
    placement = _placement(entry)
    if not placement:
        return entry
    try:
        placement.obstacle.check_size(recipe.grid, placement.first, placement.last)
    except ParameterError:
        return entry
    first, last = ends_by(recipe.grid, placement, generator(recipe.seed, index, placement.key or ""))
    return {**entry, "first": list(first), "last": list(last)}


def _placement(entry: Entry) -> Placement | None:
    """The obstacle of an entry; None if it is invalid."""
    try:
        return decode_placement(entry)
    except ParameterError:
        return None


def _cell(place: Json) -> tuple[int, ...]:
    """A place of two numbers; empty for any other, such as a random one."""
    known = isinstance(place, (list, tuple)) and len(place) == 2 and all(isinstance(at, int) for at in place)
    return tuple(place) if known else ()
