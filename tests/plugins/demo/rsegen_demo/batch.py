"""A simulator of many worlds, in which robots glide over all blocks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from rsegen.field.stepfield import Array
from rsegen.recipe.recipe import Recipe
from rsegen.scene.scene import Scene
from rsegen.simulators.batch import BatchSimulator, BatchWorlds
from rsegen.simulators.embedded import PlacedRobot


class Flock(BatchWorlds):
    """Worlds without blocks, in which robots do not turn."""

    step_seconds: ClassVar[float] = 0.01

    def __init__(self, robots: Sequence[PlacedRobot]) -> None:
        starts = [robot.start for robot in robots]
        self._poses = np.array([(at.x, at.y, at.z, at.roll, at.pitch, at.yaw) for at in starts])
        self._speeds = np.zeros(len(starts))

    def poses(self) -> Array:
        """Return where they are."""
        return self._poses.copy()

    def drive(self, v: Array, w: Array) -> None:
        """Set their speeds."""
        self._speeds = v

    def step(self, steps: int) -> None:
        """Move along x."""
        self._poses[:, 0] += self._speeds * steps * self.step_seconds

    def problems(self) -> Mapping[int, str]:
        """Return none."""
        return {}


class AirBatch(BatchSimulator):
    """Many worlds without blocks."""

    name: ClassVar[str] = "air_batch"
    title: ClassVar[str] = "Much Thin Air"

    def refuse_missing(self) -> None:
        """It is always there."""

    def size(self, recipe: Recipe) -> int:
        """As many as there are."""
        return 1000

    def worlds(
        self, scenes: Sequence[Scene], robots: Sequence[PlacedRobot], *, motors: str = "reaction"
    ) -> BatchWorlds:
        """Return worlds without blocks."""
        return Flock(robots)
