"""How hard a map is: the rms step between its blocks, and the same map with a share of it.

    levels h --eased--> floor(s h + u), u near 1/2: every block s times as high, rounded to whole units

s is the scale at which the rms step is nearest to `difficulty` times that of h. Blocks of one height are raised one
after the other, in an order that u gives: plateau by plateau at random, and over a plateau from one side. So what is
level stays level but for one edge, what is higher stays higher, and the measure moves by one block at a time.
docs/difficulty.md has the formulas and how near they come.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from math import sqrt

import numpy as np

from rsegen.field.metrics.regions import connected, neighbours
from rsegen.field.stepfield import Array, Ints, Levels
from rsegen.params.streams import generator
from rsegen.recipe.recipe import Recipe

_KEY = "difficulty of the map"
"""Names its randomness; no obstacle's key has blanks."""


def eased(levels: Levels, recipe: Recipe, index: int) -> Levels:
    """The blocks of map `index` at the recipe's difficulty; where they have no steps, they are lowered as one."""
    if recipe.difficulty == 1:
        return levels
    measure = partial(roughness, parts=parts_of(levels, recipe))
    asked = recipe.difficulty * measure(levels)
    if not asked:
        return lowered(levels, 0.5, recipe.difficulty)
    drawn = generator(recipe.seed, index, _KEY).random(levels.shape)
    return nearest(partial(lowered, levels, _rounding(levels, drawn)), measure, asked, _halvings(levels))


def lowered(levels: Levels, rounding: Array | float, scale: float) -> Levels:
    """floor(s h + u): `levels` themselves at scale 1, and level ground at 0."""
    return np.asarray(np.floor(levels * scale + rounding), dtype=np.int16)


def parts_of(levels: Levels, recipe: Recipe) -> tuple[int, int]:
    """Cells along x and y between which no frame stands."""
    n_x, n_y = levels.shape
    return (recipe.chunk_size, recipe.chunk_size) if recipe.boundary == "divided" else (n_x, n_y)


def roughness(levels: Levels, parts: tuple[int, int]) -> float:
    """sqrt(sum dh^2) over all neighbours without a frame between them: the rms step, but for a factor."""
    n_x, n_y = levels.shape
    x, y = levels.reshape(-1, parts[0], n_y), levels.reshape(n_x, -1, parts[1])
    steps = (x[:, 1:], x[:, :-1]), (y[:, :, 1:], y[:, :, :-1])
    rises = [np.subtract(high, low, dtype=np.int64) for high, low in steps]
    return sqrt(sum(int(np.vdot(rise, rise)) for rise in rises))


def nearest(at: Callable[[float], Levels], measure: Callable[[Levels], float], asked: float, halvings: int) -> Levels:
    """Of the two fields beside the place where the measure passes what is asked, the one that is nearer to it.

    By halving. Whatever the measure does in between, who asks for more goes the same way or higher: so fields are
    nested.
    """
    low, high = 0.0, 1.0
    for _ in range(halvings):
        middle = (low + high) / 2
        low, high = (middle, high) if measure(at(middle)) < asked else (low, middle)
    lower, upper = at(low), at(high)
    return upper if asked - measure(lower) > measure(upper) - asked else lower


def _rounding(levels: Levels, drawn: Array) -> Array:
    """u of every cell, 1/2 but for its place in the order: so little beside it that what is higher is raised first."""
    plateau = drawn.ravel()[_plateaus(levels)]
    place = np.empty(levels.size)
    place[np.argsort(plateau, kind="stable")] = np.arange(levels.size) / levels.size
    return np.asarray(0.5 + (place.reshape(levels.shape) - 0.5) / (4 * int(levels.max())))


def _plateaus(levels: Levels) -> Ints:
    """For each cell, in one row, the first cell of those of its level that it hangs together with."""
    row, (low, high) = levels.ravel(), neighbours(levels.shape)
    level = row[low] == row[high]
    return connected(levels.size, low[level], high[level])


def _halvings(levels: Levels) -> int:
    """So many that blocks of one level are told apart: their scales are 1 / (4 N top^2) apart or more."""
    return min((4 * levels.size * int(levels.max()) ** 2).bit_length() + 1, 52)
