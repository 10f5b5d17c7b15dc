"""Random coordinates of the two ends of an obstacle that has a given size."""

from __future__ import annotations

import numpy as np

from rsegen.params.places import Cell, Coordinate
from rsegen.params.streams import randint


def random_ends(first: Coordinate, last: Coordinate, span: int, cells: int, rng: np.random.Generator) -> Cell:
    """Both coordinates on one axis, `span` cells apart if at least one of them is random."""
    if first == "random" and last == "random":
        low = randint(rng, 0, cells - 1 - span)
        return low, low + span
    if first == "random":
        return _beside(last, span, cells), last  # type: ignore[arg-type,return-value]  # last is given
    if last == "random":
        return first, _beside(first, span, cells)
    return first, last


def _beside(at: int, span: int, cells: int) -> int:
    """The coordinate `span` cells further, or back if that is outside the map; always on the map."""
    return at + span if at + span < cells else max(at - span, 0)
