"""From the frame of a cloud to that of the map that was found in it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from rsegen.field.scanning.grid import Grid
from rsegen.field.scanning.ground import GroundFrame
from rsegen.field.scanning.reading import Reading
from rsegen.field.stepfield import Array
from rsegen.params.places import Cell


@dataclass(frozen=True, kw_only=True, slots=True)
class Transform:
    """`rotation @ point + translation` is a point of the cloud in another frame; cells: of that frame along x and y.

    rotation: (3, 3); translation: (3,) [m]; width: of a cell [m].
    """

    rotation: Array
    translation: Array
    cells: Cell
    width: float

    @classmethod
    def of(cls, ground: GroundFrame, grid: Grid, reading: Reading, base: float) -> Transform:
        """Into the frame of a reading, whose cell (0, 0) has its corner at the origin; base: height of level 0 [m]."""
        about_z = np.eye(3)
        about_z[:2, :2] = grid.rotation
        corner = grid.origin + np.array(reading.first) * grid.width
        n_x, n_y = reading.heights.shape
        return cls(
            rotation=about_z @ ground.rotation,
            translation=-np.array([*corner, ground.offset + base]),
            cells=(n_x, n_y),
            width=grid.width,
        )

    def after(self, middle: Array) -> Transform:
        """The same for points from which a middle (3,) was not yet subtracted."""
        return replace(self, translation=self.translation - self.rotation @ middle)

    def quarter_turned(self, turns: int) -> Transform:
        """The same with the cells turned counterclockwise about their middle, which gets its corner at the origin."""
        n_x, n_y = self.cells
        cells = (n_x, n_y) if turns % 2 == 0 else (n_y, n_x)
        c, s = ((1, 0), (0, 1), (-1, 0), (0, -1))[turns % 4]
        about_z = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        old, new = (np.array([*half, 0]) * self.width / 2 for half in ((n_x, n_y), cells))
        return replace(
            self,
            rotation=about_z @ self.rotation,
            translation=about_z @ (self.translation - old) + new,
            cells=cells,
        )

    def moved(self, corner: Cell, shape: Cell) -> Transform:
        """Into the frame of a rectangle of the cells: its middle is the origin."""
        shift = [(at + cells / 2) * self.width for at, cells in zip(corner, shape, strict=True)]
        return replace(self, translation=self.translation - np.array([*shift, 0]), cells=shape)
