"""The boards of frames: two as long as the frame, and two between them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass

from rsegen.exporters.sheet.cutting import nanometres
from rsegen.recipe.recipe import Recipe


@dataclass(frozen=True, kw_only=True, slots=True)
class Frames:
    """Equal frames: their number, and the number of boards of each length [nm] per frame, the longest first."""

    number: int
    boards: Mapping[int, int]

    @property
    def all_boards(self) -> dict[int, int]:
        """The number of boards of each length of all frames."""
        return {length: self.number * count for length, count in self.boards.items()}

    @property
    def timber(self) -> int:
        """The length of all boards in nanometres."""
        return sum(length * count for length, count in self.all_boards.items())


def frames(recipe: Recipe, play: int = 0) -> Frames | None:
    """The frames of a map, or None if it has none above the ground; play: of the blocks inside, in nanometres."""
    if recipe.boundary == "none" or not recipe.frame_height_cm:
        return None
    m_x, m_y = recipe.chunks
    number, (n_x, n_y) = (
        (m_x * m_y, (recipe.chunk_size,) * 2) if recipe.boundary == "divided" else (1, recipe.grid.shape)
    )
    width = nanometres(recipe.block_width_cm)
    boards = Counter({(n_x + 2) * width + play: 2})
    boards[n_y * width + play] += 2
    return Frames(number=number, boards=dict(sorted(boards.items(), reverse=True)))
