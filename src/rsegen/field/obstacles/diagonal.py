"""The diagonal barrier of the paper's figure 2."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from rsegen.field.obstacles.barrier import Barrier
from rsegen.field.obstacles.base import Grid, register
from rsegen.params.places import ANYWHERE, Cell, Place
from rsegen.params.streams import randint


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class DiagonalBarrier(Barrier):
    """A straight ridge in any direction. Without `first` and `last`, its ends are drawn on two opposite map edges."""

    kind: ClassVar[str] = "diagonal_barrier"

    def ends(self, grid: Grid, first: Place, last: Place, rng: np.random.Generator) -> tuple[Cell, Cell]:
        """Without given ends, a random cell on each of two opposite map edges; else random coordinates are uniform."""
        if first == last == ANYWHERE:
            across = randint(rng, 0, 1)
            opposite: tuple[Place, Place] = ((0, "random"), (grid.n_x - 1, "random"))
            upright: tuple[Place, Place] = (("random", 0), ("random", grid.n_y - 1))
            first, last = upright if across else opposite
        return Barrier.ends(self, grid, first, last, rng)
