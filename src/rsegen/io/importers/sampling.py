"""The heights of blocks from a finer, shifted or turned table of heights."""

from __future__ import annotations

from math import ceil, cos, isqrt, radians, sin

import numpy as np

from rsegen.field.stepfield import Array
from rsegen.params.places import Cell

_MOST_ALONG = 15
"""Samples along a side of a block at most."""

_MOST_SAMPLES = 2**26


def sampled(
    heights: Array, size: Cell, per_block: tuple[float, float], origin: tuple[float, float], turn: float
) -> Array:
    """The median height over each block, shape `size`; nan where more than half of a block is nan or outside.

    heights: (n_x, n_y) of a file's cells, nan for holes; per_block: its cells along a block's sides; origin: the
    map's south-west corner, in cells from the file's; turn: of the map in the file, degrees counterclockwise.
    """
    most = max(min(_MOST_ALONG, isqrt(_MOST_SAMPLES // (size[0] * size[1]))), 1)
    samples = [min(max(ceil(cells), 1), most) for cells in per_block]
    along = [
        (np.arange(blocks * n).reshape(blocks, n) + 0.5) / n * cells
        for blocks, n, cells in zip(size, samples, per_block, strict=True)
    ]
    c, s = cos(radians(turn)), sin(radians(turn))
    rows = (_heights_at(heights, origin, u[:, None, None], along[1], (c, s)) for u in along[0])
    return np.array([_medians(row.transpose(1, 0, 2).reshape(size[1], -1)) for row in rows])


def _heights_at(heights: Array, origin: tuple[float, float], u: Array, v: Array, turned: tuple[float, float]) -> Array:
    """The heights of the file at points u, v of the map."""
    c, s = turned
    x, y = (
        np.floor(np.round(each, 6)).astype(np.int64) for each in (origin[0] + u * c - v * s, origin[1] + u * s + v * c)
    )
    n_x, n_y = heights.shape
    inside = (x >= 0) & (x < n_x) & (y >= 0) & (y < n_y)
    return np.where(inside, heights[x.clip(0, n_x - 1), y.clip(0, n_y - 1)], np.nan)


def _medians(samples: Array) -> Array:
    """The lower median of each row, nan if more than half of it is nan."""
    ordered = np.sort(samples, axis=1)
    known = np.count_nonzero(~np.isnan(ordered), axis=1)
    middle = np.take_along_axis(ordered, np.maximum(known - 1, 0)[:, None] // 2, axis=1)[:, 0]
    return np.where(2 * known >= samples.shape[1], middle, np.nan)
