"""Downsampling: a large map in fewer and larger cells, which is quick to draw."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rsegen.field.stepfield import CellWindow, StepField


def coarseness(field: StepField, most: int) -> int:
    """The downsampling factor per side that gives at most about `most` x `most` cells."""
    n_x, n_y = field.shape
    return max(min(math.ceil(math.sqrt(n_x * n_y) / most), n_x, n_y), 1)


def coarse(field: StepField, factor: int) -> StepField:
    """The field downsampled: cells `factor` times as wide, each the highest of those under it; a rest is cut off."""
    if factor == 1:
        return field
    i, j = _highest(field, factor)
    return StepField(
        levels=field.levels[i, j],
        frame=field.frame[i, j],
        block_width=field.block_width * factor,
        unit=field.unit,
        frame_height=field.frame_height,
    )


def coarse_window(field: StepField, window: CellWindow, factor: int) -> CellWindow:
    """The cells of the downsampled field that a window of the field overlaps."""
    x, y = (
        slice(min(part.start // factor, cells // factor - 1), min(-(-part.stop // factor), cells // factor))
        for part, cells in zip(window, field.shape, strict=True)
    )
    return x, y


def _highest(field: StepField, factor: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """The indices of the highest of every `factor` x `factor` cells."""
    n_x, n_y = (cells // factor for cells in field.shape)
    parts = field.heights[: n_x * factor, : n_y * factor].reshape(n_x, factor, n_y, factor)
    within = parts.transpose(0, 2, 1, 3).reshape(n_x, n_y, -1).argmax(axis=-1)
    return np.arange(n_x)[:, None] * factor + within // factor, np.arange(n_y)[None, :] * factor + within % factor
