"""Slopes: an even rise of steps of one unit, as a straight ramp or from all sides to a platform.

    level = (levels - 1) (d + 1) / D, rounded down, at most levels - 1      d: cells from the first end, or from the rim

D is the length of a ramp in cells, whose last cell is the highest; on a pyramid it is the number of rings up to the
platform. So a slope always reaches its highest level, where stairs keep their steps alike. `down` turns all levels
over. The arithmetic is in whole numbers, a few operations per cell. Trainers of legged robots have the same pyramids as
height fields in metres (`slope`, `platform_width`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from rsegen.field.stepfield import Array, Levels, Mask
from rsegen.obstacles.base import UpOrDown, inward, register
from rsegen.params.sorts import Cell, Choice, Integer


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Slope(UpOrDown):
    """An even slope, up or down: a pyramid with a platform in its middle, or a straight ramp along x or y."""

    kind: ClassVar[str] = "slope"
    also: ClassVar[tuple[str, ...]] = ("ramp", "incline", "pyramid")

    shape: Annotated[
        str,
        Choice(
            ("pyramid", "x", "y"),
            help="pyramid: from all sides to the platform in the middle; x, y: a ramp along x or y, from first to last",
        ),
    ] = "pyramid"
    direction: Annotated[
        str, Choice(("up", "down"), help="down: into the ground, which has to be high enough (ground_level)")
    ] = "up"
    platform_width: Annotated[
        int,
        Integer(1, 1000, unit="blocks", usual=(1, 10), help="smallest side of the platform in the middle of a pyramid"),
    ] = 2

    def laid_out(self, shape: Cell, drawn: Array) -> tuple[Levels, Mask]:
        """Return the level of each cell; all cells are covered."""
        if self.shape == "pyramid":
            length = max((min(shape) - self.platform_width) // 2 + 1, 1)
        else:
            length = shape["xy".index(self.shape)]
        levels = (self.levels - 1) * np.minimum(inward(self.shape, shape) + 1, length) // length
        return (levels if self.direction == "up" else -levels).astype(np.int16), np.ones(shape, dtype=bool)
