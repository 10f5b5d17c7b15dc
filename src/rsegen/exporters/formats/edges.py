"""The edges of a field: every side of a cell at which the height changes."""

from __future__ import annotations

import numpy as np

from rsegen.field.stepfield import Array, StepField

COLUMNS = {
    "x0_m": "x of one end, the one of smaller x or y",
    "y0_m": "its y",
    "x1_m": "x of the other end",
    "y1_m": "its y",
    "rise_x": "direction in which the height rises: 1 or -1 along x, else 0",
    "rise_y": "the same along y",
    "low_level": "level of the lower cell; 0 outside the map, -1 for a frame",
    "low_m": "its height above the ground",
    "high_level": "level of the higher cell; -1 for a frame",
    "high_m": "its height above the ground",
}
"""The columns of `edges`, and their meaning."""

FRAME = -1
"""The level of frames in `edges`, as they have none."""


def edges(field: StepField) -> Array:
    """The edges of a field, one per row (n, 10): the sides of cells at which the height changes, also to the ground.

    First those that run along y, then those along x; by i, then by j.
    """
    line_x, line_y = field.edges()
    levels = np.pad(np.where(field.frame, FRAME, field.levels), 1).astype(np.float64)
    heights = np.pad(field.heights, 1)
    along_y = _jumps(levels[:, 1:-1], heights[:, 1:-1])
    i, j = along_y[:, :2].astype(int).T
    west_east = [line_x[i], line_y[j], line_x[i], line_y[j + 1], along_y[:, 2], np.zeros(len(i)), *along_y[:, 3:].T]
    along_x = _jumps(levels[1:-1].T, heights[1:-1].T)
    along_x = along_x[np.lexsort((along_x[:, 0], along_x[:, 1]))]
    j, i = along_x[:, :2].astype(int).T
    south_north = [line_x[i], line_y[j], line_x[i + 1], line_y[j], np.zeros(len(i)), along_x[:, 2], *along_x[:, 3:].T]
    return np.concatenate([np.stack(west_east, axis=1), np.stack(south_north, axis=1)])


def _jumps(levels: Array, heights: Array) -> Array:
    """The edges across the first axis: (n, 7) line, row, sign of the rise; level and height of low and high."""
    at = np.argwhere(heights[1:] != heights[:-1])
    line, row = at.T
    rises = heights[line + 1, row] > heights[line, row]
    low, high = line + ~rises, line + rises
    sign = np.where(rises, 1, -1)
    found = [line, row, sign, levels[low, row], heights[low, row], levels[high, row], heights[high, row]]
    return np.stack(found, axis=1).astype(np.float64)
