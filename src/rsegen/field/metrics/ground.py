"""What a robot drives on: heights in whole nanometres, frames counted, each the highest under the robot's width.

A frame is crossed, not driven along: it would lead round every field, as no robot is tested. So no move along x is in a
row that is all frame, none along y in a column that is.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rsegen.field.robot_limits import NANOMETRES, cells_aside
from rsegen.field.stepfield import Ints, Mask, StepField

Heights = NDArray[np.int64]


class Ground(NamedTuple):
    """Heights (n_x, n_y) in nanometres; the rows j in which moves along x are, the columns i in which those along y."""

    heights: Heights
    rows: Mask
    columns: Mask

    def moves(self) -> tuple[Ints, Ints]:
        """Every move between two neighbours once: the cell of smaller x or y, the other one, as places in the array."""
        cells = np.arange(self.heights.size).reshape(self.heights.shape)
        along_x, along_y = cells[:, self.rows], cells[self.columns]
        low = np.concatenate([along_x[:-1].ravel(), along_y[:, :-1].ravel()])
        high = np.concatenate([along_x[1:].ravel(), along_y[:, 1:].ravel()])
        return low, high


def ground(field: StepField, width: float) -> Ground:
    """Of every cell, frames too: what carries a robot of that width in metres whose middle is there."""
    heights = _widened(_heights(field), cells_aside(field, width))
    return Ground(heights, rows=field.inside(1), columns=field.inside(0))


def lane(field: StepField, width: float, axis: int) -> Ground:
    """The same with the level ground before and behind the field along an axis, which becomes the first."""
    margin = cells_aside(field, width) + 1
    heights = _heights(field) if axis == 0 else _heights(field).T
    widened = _widened(np.pad(heights, ((margin, margin), (0, 0))), margin - 1)
    columns = np.pad(field.inside(axis), margin, constant_values=True)
    return Ground(widened, rows=field.inside(1 - axis), columns=columns)


def _heights(field: StepField) -> Heights:
    return np.rint(field.heights * NANOMETRES).astype(np.int64)


def _widened(heights: Heights, aside: int) -> Heights:
    """The highest of the (2 aside + 1)^2 cells round each; beyond the field there is the ground, which is no higher."""
    for _axis in (0, 1):
        heights = _highest(np.pad(heights, ((aside, aside), (0, 0))), 2 * aside + 1).T
    return heights


def _highest(heights: Heights, cells: int) -> Heights:
    """Of so many rows from each row on the highest, for each column, by doubling what one row stands for."""
    stands_for = 1
    while stands_for < cells:
        ahead = min(stands_for, cells - stands_for)
        heights = np.maximum(heights[:-ahead], heights[ahead:])
        stands_for += ahead
    return heights
