"""Which cell of a map a ray meets first, such as that under a click in the 3D view."""

from __future__ import annotations

import numpy as np

from rsegen.field.stepfield import Array, CellWindow, StepField
from rsegen.params.places import Cell


def cell_hit(field: StepField, start: Array, stop: Array) -> Cell | None:
    """The field cell whose top or side a ray between two points [m] meets first; None if it meets none.

    Between two lines of the grid the ray is over one cell, and meets it if its lower end there is below the top.
    """
    along = stop - start
    shares = [np.array([0.0, 1.0])]
    for axis, edges in enumerate(field.edges()):
        if along[axis]:
            shares.append((edges - start[axis]) / along[axis])
    at = np.unique(np.clip(np.concatenate(shares), 0, 1))
    middles = start[None, :2] + (at[:-1] + at[1:])[:, None] / 2 * along[:2]
    lowest = np.minimum(start[2] + at[:-1] * along[2], start[2] + at[1:] * along[2])
    i, j = np.floor((middles + np.array(field.extent) / 2) / field.block_width).astype(int).T
    (over,) = np.nonzero((i >= 0) & (i < field.shape[0]) & (j >= 0) & (j < field.shape[1]))
    met = over[lowest[over] <= field.heights[i[over], j[over]]]
    return (int(i[met[0]]), int(j[met[0]])) if len(met) else None


def is_inside(cell: Cell, window: CellWindow | None) -> bool:
    """Whether a field cell is in a window; in none if there is no window."""
    return window is not None and all(part.start <= at < part.stop for at, part in zip(cell, window, strict=True))
