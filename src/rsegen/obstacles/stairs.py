"""Stairs of steps that are all alike: a straight flight, or a pyramid of rings around a platform.

    k = floor(d / step_width) + 1,  level = min(k, K) step_height      d: cells from the first end, or from the rim

K steps are as many as `levels` allows: K = floor((levels - 1) / step_height). A pyramid has fewer if its platform would
be too small otherwise, and the rest of a flight that is longer than its steps is a landing on the last level. `down`
turns all levels over. The cost is a few operations per cell. Trainers of legged robots have the same pyramids, there
made of metres (`step_width`, `step_height` and the width of a platform in the middle of a tile).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from rsegen.errors import ParameterError
from rsegen.field.stepfield import Array, Levels, Mask
from rsegen.obstacles.base import Obstacle, UpOrDown, inward, register
from rsegen.params.sorts import Cell, Choice, Integer


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Stairs(UpOrDown):
    """Stairs of equal steps, up or down: a pyramid with a platform in its middle, or a straight flight along x or y."""

    kind: ClassVar[str] = "stairs"
    also: ClassVar[tuple[str, ...]] = ("staircase", "steps")

    shape: Annotated[
        str,
        Choice(
            ("pyramid", "x", "y"),
            help="pyramid: from all sides to the platform in the middle; x, y: a flight along x or y, from first to "
            "last",
        ),
    ] = "pyramid"
    direction: Annotated[
        str, Choice(("up", "down"), help="down: into the ground, which has to be high enough (ground_level)")
    ] = "up"
    step_width: Annotated[
        int, Integer(1, 1000, unit="blocks", usual=(1, 10), help="depth of a step, from one edge to the next")
    ] = 1
    step_height: Annotated[int, Integer(1, 32766, unit="units", usual=(1, 10), help="height of a step")] = 1
    platform_width: Annotated[
        int,
        Integer(1, 1000, unit="blocks", usual=(1, 10), help="smallest side of the platform in the middle of a pyramid"),
    ] = 2

    def __post_init__(self) -> None:
        Obstacle.__post_init__(self)
        if self.step_height >= self.levels:
            raise ParameterError("step_height", f"{self.step_height} is more than the highest level, {self.levels - 1}")

    def laid_out(self, shape: Cell, drawn: Array) -> tuple[Levels, Mask]:
        """Return the level of each step; all cells are covered."""
        steps = (self.levels - 1) // self.step_height
        if self.shape == "pyramid":
            steps = max(1, min(steps, (min(shape) - self.platform_width) // 2 // self.step_width + 1))
        levels = np.minimum(inward(self.shape, shape) // self.step_width + 1, steps) * self.step_height
        levels = levels if self.direction == "up" else -levels
        return levels.astype(np.int16), np.ones(shape, dtype=bool)
