"""The two ends of an obstacle in a map, where random ones are drawn under a condition, as of their distance.

Each function draws from the generator of one obstacle, in a fixed order, or from `Streams` of many maps, whose numbers
are arrays with a value for each map. Kinds whose ends do not depend on each other draw them by `Obstacle.ends`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from rsegen.params.arrays import greatest, least, where
from rsegen.params.sorts import Cell, Coordinate, Place
from rsegen.params.streams import Streams, randint


def random_ends(first: Coordinate, last: Coordinate, span: int, cells: int, rng: np.random.Generator) -> Cell:
    """Return both coordinates on one axis of `cells` cells, `span` cells apart if at least one of them is random."""
    if first == "random" and last == "random":
        low = randint(rng, 0, cells - 1 - span)
        return low, low + span
    if first == "random":
        return _at_distance(last, span, cells), last  # type: ignore[arg-type,return-value]  # last is given
    if last == "random":
        return first, _at_distance(first, span, cells)
    return first, last


def ends_of_size(map_size: Cell, first: Place, last: Place, size: Cell, rng: np.random.Generator) -> tuple[Cell, Cell]:
    """Return ends; random ones make a rectangle of this size, in cells, inside the map."""
    (x1, x2), (y1, y2) = (
        random_ends(a, b, own - 1, cells, rng) for a, b, own, cells in zip(first, last, size, map_size, strict=True)
    )
    return (x1, y1), (x2, y2)


def square_ends(
    map_size: Cell, chunk_size: int, first: Place, last: Place, rng: np.random.Generator
) -> tuple[Cell, Cell]:
    """Return ends; random ones make a square inside the map, with a random side of L/2..L if no side is given.

    map_size: cells along x and y; chunk_size: L
    """
    fixed = [abs(a - b) + 1 for a, b in zip(first, last, strict=True) if a != "random" and b != "random"]
    side = fixed[0] if fixed else randint(rng, (chunk_size + 1) // 2, chunk_size)
    n_x, n_y = map_size
    return ends_of_size(map_size, first, last, (least(side, n_x), least(side, n_y)), rng)


def _at_distance(at: int, span: int, cells: int) -> int:
    """Return the coordinate `span` cells further, or back if that is outside the map; always on the map."""
    return where(at + span < cells, at + span, greatest(at - span, 0))  # type: ignore[no-any-return]  # as its arguments


def ends_of_one(
    options: Sequence[Callable[[np.random.Generator], tuple[Cell, Cell]]], rng: np.random.Generator
) -> tuple[Cell, Cell]:
    """Return the ends that one of several functions gives, each with equal probability; nothing is drawn after them."""
    drawn = randint(rng, 0, len(options) - 1)
    if len(options) == 1:
        return options[0](rng)
    if not isinstance(rng, Streams):
        return options[drawn](rng)
    # Of many maps, all options are drawn from the same place, and each map takes the one that its number chose.
    ends = [option(rng.copy()) for option in options]  # type: ignore[arg-type]  # streams in place of a generator
    return tuple(
        tuple(np.select([drawn == option for option in range(len(ends))], at) for at in zip(*end, strict=True))
        for end in zip(*ends, strict=True)
    )  # type: ignore[return-value]  # two ends of two arrays
