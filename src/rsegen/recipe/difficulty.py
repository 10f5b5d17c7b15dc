"""Scale a map to its difficulty: a share of the rms step between the blocks of its obstacles.

    levels h --scaled--> floor(s h + u), u near 1/2: every block s times as high, rounded to whole units

Levels count from the ground and are negative in pits, which get shallower.

s is the scale at which the rms step is nearest to `difficulty` times that of h. Blocks of one height are raised one
after the other, in an order given by u: plateau by plateau at random, and from one side over a plateau. So a plateau
stays flat but for one edge, higher blocks stay higher, and the rms step changes by one block at a time.
docs/difficulty.md has the formulas and their accuracy.

The scale is found by bisection, in as many halvings as it takes to separate any two blocks: 14 for a pallet of five
levels, each a pass over the cells. Many maps are scaled by the same passes. On a field of few blocks one block is a
large share of the roughness, so there the result is as near as one block allows, and no nearer.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from math import sqrt
from typing import Any

import numpy as np

from rsegen.field.graphs import component_labels
from rsegen.field.stepfield import Levels
from rsegen.field.sweeps import LARGE, plateaus
from rsegen.params.arrays import (
    asarray,
    cast,
    least,
    maps_first,
    maps_last,
    namespace,
    places_of,
    ranks_of_draws,
    where,
)
from rsegen.params.streams import Streams, generator
from rsegen.recipe.map_design import MapDesign

_KEY = "difficulty of the map"
"""Name of the random stream of a map's difficulty; no key of an obstacle has blanks."""


def scaled_to_difficulty(levels: Levels, design: MapDesign, index: int) -> Levels:
    """Return the levels of map `index` at the difficulty of its design; a field without steps is lowered as a whole."""
    difficulty = design.difficulty_of(index)
    if difficulty == 1:
        return levels
    field, measure = levels.astype(float), partial(roughness, parts=parts_of(levels.shape, design))
    designed = measure(field)
    if not designed * difficulty:
        return scaled(field, 0.5, difficulty).astype(np.int16)  # type: ignore[no-any-return]  # as the field
    rounding = _rounding(levels[None], generator(design.seed, index, _KEY).random((1, *levels.shape)))[0]
    levels_at_scale: Levels = nearest_field(
        partial(scaled, field, rounding), measure, designed, difficulty, int(_halvings(levels[None])[0])
    )
    return levels_at_scale.astype(np.int16)


def scaled_to_difficulties(levels: Any, design: MapDesign, indices: Sequence[int]) -> Any:
    """Return the levels of many maps (maps, n_x, n_y), an array or a tensor, each at its difficulty."""
    measure = partial(roughness, parts=parts_of(levels.shape[1:], design))
    difficulties = asarray(np.array(design.difficulties_of(indices)), levels)
    halvings = _halvings(levels)
    most = int(halvings.max())
    kind = "float32" if (float(_top(levels).max()) + 1) * 2.0**most <= _MOST_IN_32_BITS else "float64"
    fields = maps_last(levels, kind)
    designed = measure(fields)
    result, is_steep = levels + 0, designed * difficulties > 0
    level = places_of(~is_steep & (difficulties < 1))
    if len(level):
        result[level] = maps_first(scaled(maps_last(levels[level]), 0.5, difficulties[level]))
    steep = places_of(is_steep & (difficulties < 1))
    if len(steep):
        own, chosen = Streams.of(design.seed, indices, _KEY), levels[steep]
        drawn = own.part(steep.tolist()).on_device_of(levels).arrays(levels.shape[1:])
        # Of scales of `most` binary digits, no other digits of u change a level: then few digits are enough.
        rounding = namespace(levels).floor(_rounding(chosen, drawn) * 2.0**most) / 2.0**most
        rounding, fields = maps_last(rounding, kind), fields[:, :, steep]
        nearest = nearest_field(
            lambda scale: scaled(fields, rounding, cast(scale, kind)),
            measure,
            designed[steep],
            difficulties[steep],
            halvings[steep],
        )
        result[steep] = maps_first(nearest)
    return result


def scaled(field: Any, rounding: Any, scale: Any) -> Any:
    """Return floor(s h + u) of a field (n_x, n_y), or of many (n_x, n_y, maps) with a scale each, as floats.

    A field is unchanged at s = 1, flat ground at 0.
    """
    raised = field * scale
    raised += rounding  # in place, as memory limits this, not arithmetic
    return namespace(raised).floor(raised)


def parts_of(shape: tuple[int, int], design: MapDesign) -> tuple[int, int]:
    """Return the size of the parts of a map of this shape that no frame divides, in cells along x and y."""
    return (design.chunk_size, design.chunk_size) if design.boundary == "divided" else shape


_MOST_IN_32_BITS = 2**24
"""Number up to which floats of 32 bits have all whole numbers: of parts of a unit, and of sums of squared steps."""

_MOST_IN_FLOATS = 2**20
"""Cells up to which squared steps, of 2^33 at the most, are summed as floats: these sums are below 2^53, so exact."""


def roughness(field: Any, parts: tuple[int, int]) -> Any:
    """Return sqrt(sum dh^2) over all neighbours without a frame between them: proportional to the rms step.

    A number for a field (n_x, n_y); an array for many (n_x, n_y, maps), of floats that hold sums of squared steps.
    """
    n_x, n_y, *maps = field.shape
    numbers = field if maps and n_x * n_y <= _MOST_IN_FLOATS else cast(field, "int64")
    x, y = numbers.reshape(-1, parts[0], n_y, *maps), numbers.reshape(n_x, -1, parts[1], *maps)
    rises = x[:, 1:] - x[:, :-1], y[:, :, 1:] - y[:, :, :-1]
    if not maps:
        return sqrt(sum(int(np.vdot(rise, rise)) for rise in rises))
    xp = namespace(field)
    return xp.sqrt(cast(sum((rise * rise).reshape(-1, *maps).sum(0) for rise in rises), "float64"))


def nearest_field(
    at: Callable[[Any], Any], measure: Callable[[Any], Any], designed: Any, share: Any, halvings: Any
) -> Any:
    """Return the field `at(scale)` whose measure is nearest to a share of that at scale 1, by bisection.

    designed: the measure at scale 1; at 0 it is 0. designed, share, halvings: numbers, or (maps,) for many fields. A
    larger share never gives a smaller scale, so the fields of rising difficulty are nested.
    """
    # Many maps are halved together; one whose number of halvings is reached keeps its bounds from then on.
    asked = share * designed
    low, high = (0 * asked, 0 * asked), (0 * asked + 1, designed)  # scales, and the measures there
    fewest, most = (halvings, halvings) if isinstance(halvings, int) else (int(halvings.min()), int(halvings.max()))
    for halving in range(most):
        scale = (low[0] + high[0]) / 2
        middle = scale, measure(at(scale))
        is_below, goes_on = middle[1] < asked, halving < fewest or halving < halvings
        halved = *_each(is_below, middle, low), *_each(is_below, high, middle)
        low_scale, low_measure, high_scale, high_measure = _each(goes_on, halved, (*low, *high))
        low, high = (low_scale, low_measure), (high_scale, high_measure)
    return at(where(asked - low[1] > high[1] - asked, high[0], low[0]))


def _each(condition: Any, yes: Sequence[Any], no: Sequence[Any]) -> Sequence[Any]:
    return [where(condition, if_true, if_false) for if_true, if_false in zip(yes, no, strict=True)]


def _rounding(levels: Any, drawn: Any) -> Any:
    """Return u of every cell: 1/2, changed by its place in the order so little that higher blocks are raised first."""
    cells = levels.shape[1] * levels.shape[2]
    draw_of_plateau = drawn.reshape(-1)[_plateaus(levels)]
    order = cast(ranks_of_draws(draw_of_plateau.reshape(-1, cells)), "float64") / cells
    return 0.5 + (order.reshape(levels.shape) - 0.5) / (4 * _top(levels))[:, None, None]


def _plateaus(levels: Any) -> Any:
    """Return for each cell, all maps in one row, the first cell of its connected component of equal level."""
    maps, n_x, n_y = levels.shape
    cells = n_x * n_y
    if namespace(levels) is np and maps > 1 and cells <= LARGE:
        first = plateaus(maps_last(levels, "int16")).reshape(cells, maps).T
        return (first + np.arange(0, maps * cells, cells)[:, None]).ravel()
    # Whether the next cell along x, and along y, has the same level; false at the end of an axis.
    on_x, on_y = (namespace(levels).zeros_like(levels) > 0 for _ in range(2))
    on_x[:, :-1], on_y[:, :, :-1] = levels[:, :-1] == levels[:, 1:], levels[:, :, :-1] == levels[:, :, 1:]
    x, y = places_of(on_x.reshape(-1)), places_of(on_y.reshape(-1))
    join = namespace(levels).concatenate
    return component_labels(maps * n_x * n_y, join([x, y]), join([x + n_y, y + 1]))


def _halvings(levels: Any) -> Any:
    """Return the number of halvings that separates any two blocks: their scales differ by 1 / (4 N top^2) or more."""
    apart = 4 * levels.shape[1] * levels.shape[2] * _top(levels) ** 2
    return least(namespace(levels).frexp(apart)[1] + 1, 52)  # one more than its binary digits; the bits of a float


def _top(levels: Any) -> Any:
    """Return the largest distance of any block of each map from level 0, as a float."""
    return cast(namespace(levels).amax(abs(levels), (1, 2)), "float64")
