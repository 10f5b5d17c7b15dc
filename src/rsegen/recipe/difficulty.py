"""Scales a map to its difficulty: a share of the rms step between the blocks of its obstacles.

    levels h --scaled--> floor(s h + u), u near 1/2: every block s times as high, rounded to whole units

Levels count from the ground and are negative in pits, which get shallower.

s is the scale at which the rms step is nearest to `difficulty` times that of h. Blocks of one height are raised one
after the other, in an order given by u: plateau by plateau at random, and from one side over a plateau. So a plateau
stays flat but for one edge, higher blocks stay higher, and the rms step changes by one block at a time.
docs/difficulty.md has the formulas and their accuracy.

The scale is found by bisection, in as many halvings as it takes to separate any two blocks: 14 for a pallet of five
levels, each a pass over the cells. On a field of few blocks one block is a large share of the roughness, so there the
result is as near as one block allows, and no nearer.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from math import sqrt

import numpy as np

from rsegen.field.metrics.graphs import connected, neighbours
from rsegen.field.stepfield import Array, Ints, Levels
from rsegen.params.streams import generator
from rsegen.recipe.map_design import MapDesign

_KEY = "difficulty of the map"
"""Name of the random stream of a map's difficulty; no key of an obstacle has blanks."""


def scaled_to_difficulty(levels: Levels, design: MapDesign, index: int) -> Levels:
    """Return the levels of map `index` at the difficulty of its design; a field without steps is lowered as a whole."""
    measure = partial(roughness, parts=parts_of(levels, design))
    difficulty = design.difficulty_of(index)
    if difficulty == 1:
        return levels
    asked = difficulty * measure(levels)
    if not asked:
        return scaled(levels, 0.5, difficulty)
    drawn = generator(design.seed, index, _KEY).random(levels.shape)
    return nearest(partial(scaled, levels, _rounding(levels, drawn)), measure, asked, _halvings(levels))


def scaled(levels: Levels, rounding: Array | float, scale: float) -> Levels:
    """Return floor(s h + u): `levels` unchanged at scale s = 1, flat ground at 0."""
    return np.asarray(np.floor(levels * scale + rounding), dtype=np.int16)


def parts_of(levels: Levels, design: MapDesign) -> tuple[int, int]:
    """Return the size of the parts of a map that no frame divides, in cells along x and y."""
    n_x, n_y = levels.shape
    return (design.chunk_size, design.chunk_size) if design.boundary == "divided" else (n_x, n_y)


def roughness(levels: Levels, parts: tuple[int, int]) -> float:
    """Return sqrt(sum dh^2) over all neighbours without a frame between them: proportional to the rms step."""
    n_x, n_y = levels.shape
    x, y = levels.reshape(-1, parts[0], n_y), levels.reshape(n_x, -1, parts[1])
    steps = (x[:, 1:], x[:, :-1]), (y[:, :, 1:], y[:, :, :-1])
    rises = [np.subtract(high, low, dtype=np.int64) for high, low in steps]
    return sqrt(sum(int(np.vdot(rise, rise)) for rise in rises))


def nearest(at: Callable[[float], Levels], measure: Callable[[Levels], float], asked: float, halvings: int) -> Levels:
    """Return the field `at(scale)` whose measure is nearest to `asked`, by bisection over the scale.

    Larger `asked` never gives a smaller scale, so the fields of rising difficulty are nested.
    """
    low, high = 0.0, 1.0
    for _ in range(halvings):
        middle = (low + high) / 2
        low, high = (middle, high) if measure(at(middle)) < asked else (low, middle)
    lower, upper = at(low), at(high)
    return upper if asked - measure(lower) > measure(upper) - asked else lower


def _rounding(levels: Levels, drawn: Array) -> Array:
    """Return u of every cell: 1/2, changed by its place in the order so little that higher blocks are raised first."""
    draw_of_plateau = drawn.ravel()[_plateaus(levels)]
    order = np.empty(levels.size)
    order[np.argsort(draw_of_plateau, kind="stable")] = np.arange(levels.size) / levels.size
    return np.asarray(0.5 + (order.reshape(levels.shape) - 0.5) / (4 * _farthest(levels)))


def _plateaus(levels: Levels) -> Ints:
    """Return for each cell, in one row, the first cell of its connected component of equal level."""
    row, (low, high) = levels.ravel(), neighbours(levels.shape)
    level = row[low] == row[high]
    return connected(levels.size, low[level], high[level])


def _halvings(levels: Levels) -> int:
    """Return the number of halvings that separates any two blocks: their scales differ by 1 / (4 N top^2) or more."""
    return min((4 * levels.size * _farthest(levels) ** 2).bit_length() + 1, 52)  # the bits of a float


def _farthest(levels: Levels) -> int:
    """Return the level that is farthest from the ground, up or down."""
    return max(int(levels.max()), -int(levels.min()))
