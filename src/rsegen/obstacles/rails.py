"""Rails: thin lines to step over, raised or sunk, across a way or as closed rings around the middle.

    n cells, m rails of width w, across:   rail k begins at ((2 k + 1) n - m w) / (2 m), rounded down

so that the spaces between rails differ by one cell at most. Ring k begins k s cells from the rim, where s is half of
the shorter side over the number of rings, rounded down. As many rails are made as fit with a cell between them. Across
a way they are the hurdles of trainers of legged robots, and sunk into the ground their gaps. Heights that are uneven
take one random number for each rail. The cost is a few operations per cell.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from rsegen.errors import ParameterError
from rsegen.field.stepfield import Array, Ints, Levels, Mask
from rsegen.obstacles.base import Obstacle, UpOrDown, inward, register
from rsegen.params.sorts import Cell, Choice, Integer


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Rails(UpOrDown):
    """Thin lines at equal distances, raised or sunk, across x or y or as closed rings: rails, hurdles, gaps."""

    kind: ClassVar[str] = "rails"
    also: ClassVar[tuple[str, ...]] = ("pipe", "pipes", "hurdle", "hurdles", "gap", "gaps", "trench")

    shape: Annotated[
        str, Choice(("rings", "x", "y"), help="rings: around the middle; x, y: one after the other along x or y")
    ] = "rings"
    rails: Annotated[int, Integer(1, 1000, usual=(1, 10), help="number of rails or rings, if all of them fit")] = 2
    rail_width: Annotated[int, Integer(1, 1000, unit="blocks", usual=(1, 10), help="width of a rail")] = 1
    direction: Annotated[
        str, Choice(("up", "down"), help="down: gaps in the ground, which has to be high enough (ground_level)")
    ] = "up"
    uneven: Annotated[
        int,
        Integer(
            0,
            32766,
            unit="units",
            usual=(0, 10),
            help="how far rails lie below the highest, or gaps above the deepest, at most, each at random",
        ),
    ] = 0

    def __post_init__(self) -> None:
        Obstacle.__post_init__(self)
        if self.uneven >= self.levels:
            raise ParameterError("uneven", f"{self.uneven} is more than the highest level, {self.levels - 1}")

    @property
    def draws_nothing(self) -> bool:
        """Return whether all rails are alike."""
        return self.draws_alike and not self.uneven

    def draws(self, shape: Cell) -> Cell:
        """Return the number of rails or rings, or none if all are alike."""
        return (1, len(self._starts(shape))) if self.uneven else (0, 0)

    def laid_out(self, shape: Cell, drawn: Array) -> tuple[Levels, Mask]:
        """Return the level of the rails, which alone are covered."""
        starts = self._starts(shape)
        within = inward(self.shape, shape)
        rail = np.searchsorted(starts, within, side="right") - 1
        covered: Mask = (rail >= 0) & (within < starts[rail] + self.rail_width)
        lower = np.floor(drawn[..., 0, :] * (self.uneven + 1)) if self.uneven else np.zeros(len(starts))
        heights = (self.levels - 1 - lower) * (1 if self.direction == "up" else -1)
        return np.where(covered, heights.astype(np.int16)[..., rail], np.int16(0)), covered

    def _starts(self, shape: Cell) -> Ints:
        """Return the first cell of each rail along its axis, or of each ring from the rim."""
        if self.shape == "rings":
            half = (min(shape) + 1) // 2
            rings = min(self.rails, max(half // (self.rail_width + 1), 1))
            return np.arange(rings) * (half // rings)
        cells = shape["xy".index(self.shape)]
        rails = min(self.rails, max(cells // (self.rail_width + 1), 1))
        return ((2 * np.arange(rails) + 1) * cells - rails * self.rail_width) // (2 * rails)
