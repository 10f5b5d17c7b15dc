"""The input and the result of a scan: what is known of a field before, what was found, and the transform between.

A transform is `rotation @ point + translation`, from the frame of the cloud to that of the map: upright, along the grid
of blocks, the origin at the centre of the field, z = 0 on the ground.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from rsegen.field.stepfield import Array, Ints, Mask, StepField
from rsegen.params.sorts import Cell
from rsegen.scanning.extent import FLOOR_ROWS
from rsegen.scanning.grid import CloudGrid
from rsegen.scanning.ground import GroundFrame
from rsegen.scanning.levels import Reading

SURE = 0.95
"""Levels of a lower confidence are listed: one in twenty of them may be wrong, the usual 95 % of statistics."""


_FEW_OF_SIDE = 0.5
"""Share of a side's cells that are raised, over that of all cells, below which it is sparse: random blocks of five
levels have 8 of 10 cells raised, and 3 or fewer in one side of a thousand."""


@dataclass(frozen=True, kw_only=True, slots=True)
class ScanSettings:
    """Properties of a field that are known before the scan; None is found from the cloud.

    block_width, unit: metres; blocks: along x and y, without frames; boundary: as in recipes; chunk_size: side of a
    chunk in blocks; up: a direction that is nearly up; eye: the place of the camera [m]; base: thickness of a board
    below the blocks [m], 0 for none.
    """

    block_width: float | None = None
    unit: float | None = None
    blocks: Cell | None = None
    boundary: str | None = None
    chunk_size: int | None = None
    up: Sequence[float] | None = None
    eye: Sequence[float] | None = None
    base: float | None = None

    def eye_from(self, middle: Array) -> Array | None:
        """Return the place of the camera from a point (3,) [m], None if it is not known."""
        return None if self.eye is None else np.asarray(self.eye) - middle


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Scan:
    """The field that was found in a cloud. Arrays (n_x, n_y) have all its cells, frames counted.

    levels: -1 where a cell was not seen, 0 in frames; heights: of the tops as measured [m], nan where not seen;
    confidence: the probability that a level is right, 0 where not seen; counts: points of each cell's top;
    strays: share of its points that are more than half a unit off it, 0 to 1.
    block_width, unit: as given, or found and rounded [m]; measured_width, measured_unit: as found [m].
    frame_height: metres; noise: standard deviation of a point's height [m]; base: thickness of the board below [m].
    open_sides: sides next to which almost no cell was seen, so the field may be larger; with frames only those of which
    no cell was seen either; none with a size.
    whole: cells of the whole cloud, if it ends at lines of the grid around a larger rectangle without frames.
    apart: raised cells outside of it; none with frames or a size.
    beside: cells around it that are as high as blocks, which may be obstacles of it; none with frames or a size.
    floor_rows: of cells of the floor next to it, on the side that has most.
    is_up_assumed: whether up is that of the axes of the cloud, as nothing else tells it.
    rotation (3, 3), translation (3,): `rotation @ point + translation` is the point in the map's frame [m].
    """

    levels: Ints
    heights: Array
    confidence: Array
    counts: Ints
    strays: Array
    frame: Mask
    boundary: str
    chunk_size: int | None
    block_width: float
    unit: float
    measured_width: float
    measured_unit: float
    frame_height: float
    noise: float
    base: float
    rotation: Array
    translation: Array
    open_sides: tuple[str, ...] = ()
    whole: Cell | None = None
    apart: int = 0
    beside: int = 0
    floor_rows: int = 0
    is_up_assumed: bool = False

    @property
    def has_floor(self) -> bool:
        """True if there is floor next to it, which tells which side is up, and where level 0 is."""
        return self.floor_rows >= FLOOR_ROWS

    @property
    def seen(self) -> Mask:
        """Cells that were seen."""
        return np.isfinite(self.heights)

    @property
    def tops(self) -> Ints:
        """Level of each top, also of frames, in units; -1 where a cell was not seen."""
        return np.where(self.frame, round(self.frame_height / self.unit), self.levels)

    @property
    def errors(self) -> Array:
        """Height of each top above its level [m], nan where a cell was not seen."""
        expected = np.where(self.frame, self.frame_height, np.maximum(self.levels, 0) * self.measured_unit)
        return np.asarray(self.heights - expected)

    @property
    def sides(self) -> dict[str, Mask]:
        """The cells of each side, by its name: whether they are raised."""
        raised = self.levels > 0
        return {"west": raised[0], "east": raised[-1], "south": raised[:, 0], "north": raised[:, -1]}

    @property
    def sparse_edges(self) -> dict[str, tuple[int, int]]:
        """Raised cells, and all cells, of each side of which few are raised, without frames: it may be no part of the
        field, but something that stands next to it.
        """
        if self.frame.any():
            return {}
        few = (self.levels > 0).mean() * _FEW_OF_SIDE
        return {name: (int(cells.sum()), cells.size) for name, cells in self.sides.items() if cells.mean() < few}

    @property
    def blocks(self) -> Ints:
        """The levels without frames, -1 where a block was not seen."""
        levels: Ints = self.of_blocks(self.levels)
        return levels

    @property
    def field(self) -> StepField:
        """The field, with level 0 where a block was not seen."""
        return StepField(
            levels=np.maximum(self.levels, 0).astype(np.int16),
            frame=self.frame.copy(),
            block_width=self.block_width,
            unit=self.unit,
            frame_height=self.frame_height,
        )

    def of_blocks(self, values: Any) -> Any:
        """Return values of cells (n_x, n_y) without those of frames."""
        return values[np.ix_(~self.frame.all(axis=1), ~self.frame.all(axis=0))]

    def placed(self, points: Array) -> Array:
        """Return points (n, 3) of the cloud in the map's frame [m]: about the field's centre, z above the ground."""
        return np.asarray(points @ self.rotation.T + self.translation)


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
    def of(cls, ground: GroundFrame, grid: CloudGrid, reading: Reading, base: float) -> Transform:
        """Return the transform into the frame of a reading, cell (0, 0) at the origin; base: height of level 0 [m]."""
        # Upright, then along the grid, then from the corner of its first cell.
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
        """Return the transform for points from which a middle (3,) was not yet subtracted."""
        return replace(self, translation=self.translation - self.rotation @ middle)

    def quarter_turned(self, turns: int) -> Transform:
        """Return the transform with the cells turned counterclockwise, the corner of the turned cells at the origin."""
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
        """Return the transform into the frame of a rectangle of the cells, whose middle is the origin."""
        shift = [(at + cells / 2) * self.width for at, cells in zip(corner, shape, strict=True)]
        return replace(self, translation=self.translation - np.array([*shift, 0]), cells=shape)
