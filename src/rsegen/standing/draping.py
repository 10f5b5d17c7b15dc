"""Lines laid on the blocks of a field, as a way is drawn: level on a top, and vertical at each step."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from rsegen.field.stepfield import Array, StepField


def draped(field: StepField, points: Array) -> Array:
    """Return a line through points (n, 2) [m] laid on the blocks: (m, 3), with a vertical part at every step."""
    parts = [_draped_part(field, start, end) for start, end in pairwise(points)]
    return np.concatenate(parts) if parts else np.empty((0, 3))


def _draped_part(field: StepField, start: Array, end: Array) -> Array:
    """Return a straight line laid on the blocks, cut at the edges of cells."""
    # In cells from the map's corner; t runs from 0 at the start to 1 at the end, and is cut where a cell begins.
    cells = np.stack([start, end]) / field.block_width + np.array(field.shape) / 2
    cuts = [np.array([0.0, 1.0])]
    for low, high in cells.T.tolist():
        first, last = sorted((low, high))
        between = np.arange(np.floor(first) + 1, np.ceil(last))
        cuts.append((between - low) / (high - low) if len(between) else np.empty(0))
    t = np.unique(np.concatenate(cuts))
    middles = cells[0] + ((t[:-1] + t[1:]) / 2)[:, None] * (cells[1] - cells[0])
    # Each piece is as high as the cell in its middle; its end and the next begin are one above the other.
    ends = start + np.repeat(t, 2)[1:-1, None] * (end - start)
    return np.column_stack([ends, np.repeat(_heights(field, middles), 2)])


def _heights(field: StepField, places: Array) -> Array:
    """Return the heights at places (n, 2) in cells; 0 beyond the map."""
    i, j = np.floor(places).astype(int).T
    inside = (i >= 0) & (j >= 0) & (i < field.shape[0]) & (j < field.shape[1])
    heights = np.zeros(len(places))
    heights[inside] = field.heights[i[inside], j[inside]]
    return heights
