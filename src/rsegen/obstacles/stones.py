"""Stepping stones: tops on which a robot must step, with gaps between them that are too deep to step into.

    n cells, stones of width s, gaps of width g:   k = (n - g) / (s + g) stones along an axis, rounded up

They are the fewest for which no gap is too wide, in the middle of the rectangle; its ends are in a gap, or cut off as
much of the outer stones as is too long. Gaps are `levels` - 1 units below the ground. Tops are at the level of the
ground, or up to `uneven` units below it, each drawn from one random number. The cost is a few operations per cell.
Trainers of legged robots have the same terrain in metres, with stones that also differ in width (`stone_width`,
`stone_distance`, `platform_width`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from rsegen.errors import ParameterError
from rsegen.field.stepfield import Array, Ints, Levels, Mask
from rsegen.obstacles.base import Layout, Obstacle, register
from rsegen.params.sorts import Cell, Integer


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Stones(Layout):
    """Stepping stones with gaps down into the ground between them, all alike or with tops at random levels."""

    kind: ClassVar[str] = "stones"
    also: ClassVar[tuple[str, ...]] = ("stepping_stones", "poles", "pillars")

    stone_width: Annotated[int, Integer(1, 1000, unit="blocks", usual=(1, 10), help="side of a stone")] = 2
    stone_distance: Annotated[
        int, Integer(1, 1000, unit="blocks", usual=(1, 10), help="width of the gaps between stones")
    ] = 1
    uneven: Annotated[
        int,
        Integer(
            0, 32766, unit="units", usual=(0, 10), help="how far tops lie below the ground at most, each at random"
        ),
    ] = 0
    platform_width: Annotated[
        int,
        Integer(
            0, 1000, unit="blocks", usual=(0, 10), help="side of a platform in the middle, at the level of the ground"
        ),
    ] = 0

    def __post_init__(self) -> None:
        Obstacle.__post_init__(self)
        if self.uneven >= self.levels:
            raise ParameterError("uneven", f"{self.uneven} is more than the depth of the gaps, {self.levels - 1}")

    @property
    def level_range(self) -> tuple[int, int]:
        """The lowest and the highest level, counted from the ground."""
        return 1 - self.levels, 0

    @property
    def draws_nothing(self) -> bool:
        """Return whether all tops are at the level of the ground."""
        return self.draws_alike and not self.uneven

    def draws(self, shape: Cell) -> Cell:
        """Return the number of stones along each axis, or none if all tops are at the level of the ground."""
        return (self._stones(shape[0])[1], self._stones(shape[1])[1]) if self.uneven else (0, 0)

    def laid_out(self, shape: Cell, drawn: Array) -> tuple[Levels, Mask]:
        """Return the levels of tops and gaps; all cells are covered."""
        (on_x, k_x), (on_y, k_y) = (self._stones(cells) for cells in shape)
        tops = np.full((*drawn.shape[:-2], k_x + 1, k_y + 1), 1 - self.levels, dtype=np.int16)
        tops[..., :k_x, :k_y] = -np.floor(drawn * (self.uneven + 1)) if self.uneven else 0
        levels = tops[..., on_x[:, None], on_y]
        low_x, low_y = (max(cells - self.platform_width, 0) // 2 for cells in shape)
        levels[..., low_x : low_x + self.platform_width, low_y : low_y + self.platform_width] = 0
        return levels, np.ones(shape, dtype=bool)

    def _stones(self, cells: int) -> tuple[Ints, int]:
        """Return the stone of each cell along an axis, or their number for a cell of a gap; and their number."""
        pitch = self.stone_width + self.stone_distance
        stones = max(-(-(cells - self.stone_distance) // pitch), 0)
        stone, within = np.divmod(np.arange(cells) - (cells - stones * pitch + self.stone_distance) // 2, pitch)
        return np.where((within < self.stone_width) & (stone >= 0), np.minimum(stone, stones), stones), stones
