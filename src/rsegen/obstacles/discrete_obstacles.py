"""Discrete obstacles: boxes of random sides and heights at random places, each over those before it.

    sides = least_width + floor(u (most_width - least_width + 1)),  height = 1 + floor(u (levels - 1))

Each box takes five random numbers u: of its sides along x and y, its place along x and y, at which it is whole, and its
height. In the middle a platform may stay free. The cost is a few operations per box and cell. Trainers of legged robots
have the same terrain in metres (`num_obstacles`, `obstacle_width_range`, `obstacle_height_range`, `platform_width`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from rsegen.errors import ParameterError
from rsegen.field.stepfield import Array, Levels, Mask
from rsegen.obstacles.base import Obstacle, UpOrDown, register
from rsegen.params.sorts import Cell, Choice, Integer


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class DiscreteObstacles(UpOrDown):
    """Boxes of random sides and heights at random places: on the ground, holes in it, or both."""

    kind: ClassVar[str] = "discrete_obstacles"
    also: ClassVar[tuple[str, ...]] = ("discrete", "boxes", "random_boxes", "clutter")

    count: Annotated[int, Integer(1, 10_000, usual=(1, 50), help="number of boxes")] = 10
    least_width: Annotated[int, Integer(1, 1000, unit="blocks", usual=(1, 10), help="smallest side of a box")] = 1
    most_width: Annotated[int, Integer(1, 1000, unit="blocks", usual=(1, 10), help="largest side of a box")] = 4
    direction: Annotated[
        str,
        Choice(
            ("up", "down", "both"),
            help="down: holes in the ground, which has to be high enough (ground_level); both: half of them",
        ),
    ] = "up"
    platform_width: Annotated[
        int, Integer(0, 1000, unit="blocks", usual=(0, 10), help="side of a square in the middle that stays free")
    ] = 0

    def __post_init__(self) -> None:
        Obstacle.__post_init__(self)
        if self.least_width > self.most_width:
            raise ParameterError("least_width", f"{self.least_width} is more than the largest, {self.most_width}")

    def draws(self, shape: Cell) -> Cell:
        """Return five numbers for each box."""
        return self.count, 5

    def laid_out(self, shape: Cell, drawn: Array) -> tuple[Levels, Mask]:
        """Return the level of each cell; all cells are covered."""
        sides, places, height = drawn[..., :2], drawn[..., 2:4], drawn[..., 4]
        widths = self.least_width + np.floor(sides * (self.most_width - self.least_width + 1)).astype(int)
        widths = np.minimum(widths, shape)
        low = np.floor(places * (np.array(shape) - widths + 1)).astype(int)
        if self.direction == "both":  # the lower half of the numbers are holes
            heights = np.floor(np.abs(2 * height - 1) * (self.levels - 1)) + 1
            heights = np.where(height < 0.5, -heights, heights)
        else:
            heights = (np.floor(height * (self.levels - 1)) + 1) * (1 if self.direction == "up" else -1)
        heights = np.clip(heights, 1 - self.levels, self.levels - 1)  # |2 u - 1| is 1 at u = 0
        x, y = (np.arange(cells) for cells in shape)
        on_x = (x >= low[..., :1]) & (x < low[..., :1] + widths[..., :1])
        on_y = (y >= low[..., 1:]) & (y < low[..., 1:] + widths[..., 1:])
        levels = np.zeros((*drawn.shape[:-2], *shape), dtype=np.int16)
        for box in range(self.count):
            covered = on_x[..., box, :, None] & on_y[..., box, None, :]
            np.copyto(levels, heights[..., box, None, None].astype(np.int16), where=covered)
        low_x, low_y = (max(cells - self.platform_width, 0) // 2 for cells in shape)
        levels[..., low_x : low_x + self.platform_width, low_y : low_y + self.platform_width] = 0
        return levels, np.ones(shape, dtype=bool)
