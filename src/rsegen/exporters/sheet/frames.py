"""The boards that frames are nailed of: two as long as the frame, and two between them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass

from rsegen.exporters.sheet.cutting import nanometres
from rsegen.recipe.recipe import Recipe


@dataclass(frozen=True, kw_only=True, slots=True)
class Frames:
    """So many frames alike, each of so many boards of each length [nm], the longest first."""

    number: int
    boards: Mapping[int, int]

    @property
    def all_boards(self) -> dict[int, int]:
        """Of all frames together."""
        return {length: self.number * count for length, count in self.boards.items()}

    @property
    def timber(self) -> int:
        """In all of them, nanometres."""
        return sum(length * count for length, count in self.all_boards.items())


def frames(recipe: Recipe) -> Frames | None:
    """The frames of a map, if any stand above the ground."""
    if recipe.boundary == "none" or not recipe.frame_height_cm:
        return None
    m_x, m_y = recipe.chunks
    number, (n_x, n_y) = (
        (m_x * m_y, (recipe.chunk_size,) * 2) if recipe.boundary == "divided" else (1, recipe.grid.shape)
    )
    width = nanometres(recipe.block_width_cm)
    boards = Counter({(n_x + 2) * width: 2})
    boards[n_y * width] += 2
    return Frames(number=number, boards=dict(sorted(boards.items(), reverse=True)))
