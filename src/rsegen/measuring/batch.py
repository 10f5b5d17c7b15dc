"""The metrics of many maps of one recipe at once, vectorised over the maps.

The values equal the ones of `metrics` under the names of its table, as float32; NaN stands for None. All sums are
sums of integer levels, so they are the same on every machine. Maps are the last axis of every array, so that one numpy
operation on a cell is one on that cell of all maps, in consecutive memory. Only the percolation step is not a sum: it
is swept across all maps at once, as often as the most winding path needs.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from itertools import product

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from rsegen.field.stepfield import Array, Ints, StepField
from rsegen.field.sweeps import LARGE, lanes, percolation_steps
from rsegen.field.traversability import percolation
from rsegen.params.sorts import NANOMETRES

COLUMNS = (
    "spread.lowest",
    "spread.highest",
    "spread.mean",
    "spread.deviation",
    "steps.mean",
    "steps.rms",
    "steps.highest",
    "ruggedness.tri",
    "ruggedness.surface_ratio",
    "opening.west_east",
    "opening.south_north",
)
"""Names of the metrics; lengths in metres."""

_DIRECTIONS = ("west_east", "south_north")

Table = Mapping[str, NDArray[np.float32]]
"""Array of one value per map, for each of COLUMNS."""


def batch_metrics(levels: Ints, like: StepField) -> Table:
    """Return the metrics of maps with block levels (maps, n_x, n_y) that otherwise are equal to `like`."""
    # Squares and sums of levels of 8 bits fit into 32 bits, which are twice as fast.
    exact = np.int64 if levels.itemsize > 1 else np.int32
    blocks: Ints = np.ascontiguousarray(np.moveaxis(levels, 0, -1), dtype=exact)
    whole: Ints = np.zeros((*like.shape, len(levels)), dtype=exact)
    whole[np.ix_(like.inside(0), like.inside(1))] = blocks
    columns = _spread(blocks, like) | _steps(whole, like) | _tri(whole, like) | _opening(whole, like)
    return {name: columns[name].astype(np.float32) for name in COLUMNS}


def _spread(blocks: Ints, like: StepField) -> dict[str, Array]:
    n = blocks.shape[0] * blocks.shape[1]
    total = blocks.sum(axis=(0, 1), dtype=np.int64)
    squares = np.einsum("ijk,ijk->k", blocks, blocks, dtype=np.int64)
    # Of a million blocks of ten thousand levels, the product has more than 64 bits: integers of Python have them.
    variances = n * squares.astype(object) - total.astype(object) ** 2
    return {
        "spread.lowest": blocks.min(axis=(0, 1)) * like.unit,
        "spread.highest": blocks.max(axis=(0, 1)) * like.unit,
        "spread.mean": total / n * like.unit,
        "spread.deviation": np.sqrt(variances.astype(float)) / n * like.unit,
    }


def _steps(whole: Ints, like: StepField) -> dict[str, Array]:
    # Steps are between two blocks: neither to a frame, nor across one.
    block = ~like.frame
    along_x = np.abs(whole[1:] - whole[:-1])[block[1:] & block[:-1]]
    along_y = np.abs(whole[:, 1:] - whole[:, :-1])[block[:, 1:] & block[:, :-1]]
    steps = np.concatenate([along_x, along_y])
    n, total = len(steps), steps.sum(axis=0, dtype=np.int64)
    plan = int(block.sum()) * like.block_width
    none = np.full(whole.shape[2], np.nan)
    squares = np.einsum("ik,ik->k", steps, steps, dtype=np.int64)
    return {
        "steps.mean": total / n * like.unit if n else none,
        "steps.rms": np.sqrt(squares / n) * like.unit if n else none,
        "steps.highest": steps.max(axis=0) * like.unit if n else none,
        "ruggedness.surface_ratio": 1 + total * like.unit / plan,
    }


def _tri(whole: Ints, like: StepField) -> dict[str, Array]:
    """Return the ruggedness index of each map, over the blocks with 8 neighbouring blocks."""
    n_x, n_y = like.shape
    inner = ~sliding_window_view(like.frame, (3, 3)).any(axis=(2, 3)) if min(n_x, n_y) > 2 else np.zeros((0, 0), bool)
    if not inner.any():
        return {"ruggedness.tri": np.full(whole.shape[2], np.nan)}
    middle = whole[1:-1, 1:-1]
    total = np.zeros_like(middle)
    for i, j in product(range(3), range(3)):  # the block itself adds 0
        total += (whole[i : n_x - 2 + i, j : n_y - 2 + j] - middle) ** 2
    return {"ruggedness.tri": np.sqrt(total[inner]).mean(axis=0) * like.unit / math.sqrt(8)}


def _opening(whole: Ints, like: StepField) -> dict[str, Array]:
    """Return the percolation step of each map, from the level ground on one side to the opposite side, frames counted.

    Paths across large maps are long and would need many sweeps: there, one map after the other is faster.
    """
    if like.frame.size > LARGE:
        fields = (replace(like, levels=whole[:, :, k].astype(np.int16)) for k in range(whole.shape[2]))
        steps = [percolation(field) for field in fields]
        return {f"opening.{name}": np.array([getattr(step, name) for step in steps]) for name in _DIRECTIONS}
    ways = (lanes(whole, like, 0.0, axis) for axis in (0, 1))
    return {
        f"opening.{name}": np.asarray(percolation_steps(way) * (way.unit / NANOMETRES))
        for name, way in zip(_DIRECTIONS, ways, strict=True)
    }
