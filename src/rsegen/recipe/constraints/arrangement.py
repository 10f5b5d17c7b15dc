"""Arranges the blocks in stock under a largest step: as many of them as possible, near the field that was designed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rsegen.field.fill_order import cells_with_neighbours, fill_order
from rsegen.field.obstacles.rearranged import rearranged_like
from rsegen.field.stepfield import Array, Ints, StepField
from rsegen.recipe.constraints.block_counts import BlockCounts
from rsegen.recipe.constraints.inventory import Blocks


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Stock:
    """Blocks of level 0, 1, ... in stock, and the largest step between neighbours that they are arranged under."""

    owned: Blocks
    limit: int

    def arranged(
        self, field: StepField, like: Array, rng: np.random.Generator, caps: Ints | None = None, empty: int = 0
    ) -> Ints | None:
        """Levels with about the counts of a field, as near to `like` as swaps bring them, and not above `caps`.

        They use as many blocks as `like` has above 0, or as the stock and the limit allow. None if no such order is
        found, which is so only with caps. empty: least number of cells of level 0.
        """
        there = ~field.frame
        wished = np.bincount(field.levels[there], minlength=len(self.owned))
        low = np.full(len(wished), min(empty, int(there.sum())))
        if caps is not None:
            low = np.maximum(low, np.bincount(caps[there].clip(0, len(low) - 1), minlength=len(low)).cumsum())
        n = cells_with_neighbours(fill_order(there, like), there)
        counts = BlockCounts(self.owned, self.limit, n).nearest(wished, int((like[there] > 0).sum()), low)
        levels = np.full(field.shape, -1)
        levels[there] = np.repeat(np.arange(len(counts)), counts)
        found = rearranged_like(levels, self.limit, rng, like, caps)
        return None if found is None else np.maximum(found, 0)
