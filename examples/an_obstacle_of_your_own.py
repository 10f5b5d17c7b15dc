"""A kind of obstacle: a class with its parameters and one formula. docs/plugins.md has more, and packages."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

import rsegen
from rsegen.obstacles.base import Shaped
from rsegen.params.sorts import Float


@dataclass(frozen=True, kw_only=True, slots=True)
class Waves(Shaped):
    """Waves that run along x from first to last."""

    kind: ClassVar[str] = "waves"

    length: Annotated[float, Float(1, 100, unit="blocks", help="from crest to crest")] = 5.0

    def overhang(self, grid):
        """Return 0: waves stay inside the rectangle of their two ends."""
        return 0.0

    def profile(self, x, y, first, last, grid):
        """Return the height, from 0 in a trough to 1 on a crest."""
        return (1 - np.cos(2 * np.pi * (x - first[0]) / self.length)) / 2 + 0 * y


if __name__ == "__main__":
    field = rsegen.build(rsegen.Recipe(seed=7, obstacles=[Waves(levels=4, first=(0, 0), last=(9, 9))]))
    print(field.blocks[:, 0])
