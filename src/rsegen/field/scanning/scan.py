"""What is known of a field before it is looked for in a cloud, and what was found."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rsegen.field.stepfield import Array, Ints, Mask, StepField
from rsegen.params.places import Cell

SURE = 0.95
"""Levels of a lower confidence are named to the user."""


@dataclass(frozen=True, kw_only=True, slots=True)
class ScanSettings:
    """What is known of a field before it is looked for; None is found from the cloud.

    block_width, unit: metres; blocks: along x and y, without frames; boundary: as in recipes; chunk_size: side of a
    chunk in blocks; up: a direction that is nearly up; eye: the place of the camera [m]; base: thickness of a board
    below the blocks [m].
    """

    block_width: float | None = None
    unit: float | None = None
    blocks: Cell | None = None
    boundary: str | None = None
    chunk_size: int | None = None
    up: Sequence[float] | None = None
    eye: Sequence[float] | None = None
    base: float = 0.0


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Scan:
    """The field that stands in a cloud. Arrays (n_x, n_y) have all its cells, frames counted.

    levels: -1 where a cell was not seen, 0 in frames; heights: of the tops as measured [m], nan where not seen;
    confidence: the probability that a level is right, 0 where not seen; counts: points of each cell's top.
    block_width, unit: as given, or found and rounded [m]; measured_width, measured_unit: as found [m].
    frame_height: metres; noise: standard deviation of a point's height [m].
    rotation (3, 3), translation (3,): `rotation @ point + translation` is the point in the map's frame [m].
    """

    levels: Ints
    heights: Array
    confidence: Array
    counts: Ints
    frame: Mask
    boundary: str
    chunk_size: int | None
    block_width: float
    unit: float
    measured_width: float
    measured_unit: float
    frame_height: float
    noise: float
    rotation: Array
    translation: Array

    @property
    def seen(self) -> Mask:
        """Which cells were seen."""
        return np.isfinite(self.heights)

    @property
    def errors(self) -> Array:
        """By how much each top is above its level [m], nan where a cell was not seen."""
        expected = np.where(self.frame, self.frame_height, np.maximum(self.levels, 0) * self.measured_unit)
        return np.asarray(self.heights - expected)

    @property
    def blocks(self) -> Ints:
        """The levels without frames, -1 where a block was not seen."""
        return self.levels[np.ix_(~self.frame.all(axis=1), ~self.frame.all(axis=0))]

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

    def placed(self, points: Array) -> Array:
        """Points (n, 3) of the cloud in the map's frame [m]: the field is centred, z is the height above the ground."""
        return np.asarray(points @ self.rotation.T + self.translation)
