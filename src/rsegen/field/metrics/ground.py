"""The ground that a robot of some width drives on: each cell is as high as the highest cell under the robot.

Heights are whole nanometres; frames count. A robot crosses frames but does not drive along them, which would lead
around every obstacle. So there are no moves along x in a row of only frame cells, and none along y in such a column.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rsegen.field.robot_limits import NANOMETRES, cells_to_each_side
from rsegen.field.stepfield import Ints, Mask, StepField

Heights = NDArray[np.int64]


class Ground(NamedTuple):
    """Heights (n_x, n_y) in nanometres; in which rows j moves along x are allowed, in which columns i those along y."""

    heights: Heights
    rows: Mask
    columns: Mask

    def moves(self) -> tuple[Ints, Ints]:
        """Every move between two neighbours once, as flat indices: the cell of smaller x or y, and the other one."""
        cells = np.arange(self.heights.size).reshape(self.heights.shape)
        along_x, along_y = cells[:, self.rows], cells[self.columns]
        low = np.concatenate([along_x[:-1].ravel(), along_y[:, :-1].ravel()])
        high = np.concatenate([along_x[1:].ravel(), along_y[:, 1:].ravel()])
        return low, high


def ground(field: StepField, width: float) -> Ground:
    """The ground of a field, frames counted, for robots of a width in metres whose middle is on a cell."""
    heights = _widened(field_heights(field), cells_to_each_side(field, width))
    return Ground(heights, rows=field.inside(1), columns=field.inside(0))


def below(field: StepField, width: float, cells: Mask) -> Mask:
    """The blocks below a robot of a width in metres whose middle is on one of some cells (n_x, n_y)."""
    return np.asarray((_widened(cells.astype(np.int64), cells_to_each_side(field, width)) > 0) & ~field.frame)


def lane(field: StepField, width: float, axis: int) -> Ground:
    """The ground with level ground before and behind the field along one axis, which becomes the first axis."""
    margin = cells_to_each_side(field, width) + 1
    heights = field_heights(field) if axis == 0 else field_heights(field).T
    widened = _widened(np.pad(heights, ((margin, margin), (0, 0))), margin - 1)
    columns = np.pad(field.inside(axis), margin, constant_values=True)
    return Ground(widened, rows=field.inside(1 - axis), columns=columns)


def field_heights(field: StepField) -> Heights:
    """The heights of a field's cells (n_x, n_y) in nanometres."""
    return np.rint(field.heights * NANOMETRES).astype(np.int64)


def _widened(heights: Heights, aside: int) -> Heights:
    """The maximum over the (2 aside + 1)^2 cells around each cell; outside the field is ground of height 0."""
    for _axis in (0, 1):
        heights = _highest(np.pad(heights, ((aside, aside), (0, 0))), 2 * aside + 1).T
    return heights


def _highest(heights: Heights, cells: int) -> Heights:
    """The maximum over `cells` successive rows from each row on, by doubling the number of rows covered."""
    covered = 1
    while covered < cells:
        ahead = min(covered, cells - covered)
        heights = np.maximum(heights[:-ahead], heights[ahead:])
        covered += ahead
    return heights
