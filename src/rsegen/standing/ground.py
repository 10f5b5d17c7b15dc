"""The ground of a field below robots: the height of the block under each sample of them, millions a second."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from rsegen.errors import TooLarge
from rsegen.field.stepfield import Array, StepField

_MOST_CELLS = 1 << 26
"""Cells of a ground with its border at most, whose heights are 256 MiB: those of 8,000 x 8,000 blocks."""

_BLOCK = 80_000
"""Samples that are looked at together: their arrays of 0.3 MB stay in the cache of a core, and from 87,000 on BLAS
would use a second core, and win nothing."""

SINGLE = np.float32
Singles = NDArray[np.float32]


@dataclass(frozen=True, slots=True, eq=False)
class PaddedGround:
    """The ground of a field, flat as an array with a border of level ground.

    heights: metres, (rows * columns,); width: of a block, metres; half: cells from the corner to the origin
    inside: cells from the edge at which the robot's centre of mass stays, so that all of it is above these heights
    """

    heights: Singles
    shape: tuple[int, int]
    width: float
    half: tuple[float, float]
    border: int
    inside: int

    @classmethod
    def of(cls, field: StepField, radius: float) -> PaddedGround:
        """Return the ground of a field, for robots that extend so far from their centre of mass [m].

        TooLarge if blocks are so narrow that the border of such a robot has more cells than a machine has room for.
        """
        # Twice the robot's radius: in the middle of the border all of it is above level ground, and above this array.
        inside = int(np.ceil(radius / field.block_width)) + 1
        border = 2 * inside
        n_x, n_y = field.shape
        if (n_x + 2 * border) * (n_y + 2 * border) > _MOST_CELLS:
            x, y = (side + 4 * radius for side in field.extent)
            raise TooLarge(
                f"blocks of {100 * field.block_width:.3g} cm are too narrow for a robot that is {2 * radius:.2g} m "
                f"across; blocks of {100 * 1.1 * sqrt(x * y / _MOST_CELLS):.2g} cm are wide enough on this map"
            )
        heights = np.pad(field.heights, border).astype(SINGLE)
        return cls(
            heights.ravel(), heights.shape, field.block_width, (n_x / 2 + border, n_y / 2 + border), border, inside
        )

    def below(self, x: Array, y: Array) -> Array:
        """Return the heights of the ground at places in metres, of any shape; outside the field it is 0."""
        i = np.clip(x / self.width + self.half[0], 0, self.shape[0] - 1).astype(np.intp)
        j = np.clip(y / self.width + self.half[1], 0, self.shape[1] - 1).astype(np.intp)
        return np.asarray(self.heights[i * self.shape[1] + j], np.float64)

    def middles(self, x: Array, y: Array) -> Array:
        """Return the cells in which centres of mass are, (2, n), with their fractions.

        Places so far outside that a robot there is on level ground anyway are moved to where all of it is above the
        padded ground.
        """
        placed = zip((x, y), self.half, self.shape, strict=True)
        return np.array([np.clip(at / self.width + half, self.inside, n - self.inside) for at, half, n in placed])

    def under(self, samples: Singles, middle: Array) -> Singles:
        """Return the heights of the ground under samples of robots, (n, m): (n, 2 or more, m) in cells from middles."""
        under = np.empty((len(samples), samples.shape[2]), SINGLE)
        for part in row_slices(*under.shape):
            # In place and in 32 bits, i * n_y + j: most of the time of settling is spent here.
            cells = (samples[part, :2] + middle[:, part].T[..., None].astype(SINGLE)).astype(np.int32)
            flat = cells[:, 0]
            flat *= np.int32(self.shape[1])
            flat += cells[:, 1]
            self.heights.take(flat, mode="clip", out=under[part])
        return under


def row_slices(rows: int, samples: int) -> Iterator[slice]:
    """Yield slices of some rows each, whose samples stay in the cache of a core."""
    step = max(_BLOCK // samples, 1)
    yield from (slice(begin, begin + step) for begin in range(0, rows, step))
