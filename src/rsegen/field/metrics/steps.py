"""The steps between neighbouring blocks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rsegen.field.metrics.pairs import differences
from rsegen.field.metrics.robot_limits import NANOMETRES
from rsegen.field.stepfield import StepField


@dataclass(frozen=True, kw_only=True, slots=True)
class Steps:
    """The steps |dh| between 4-neighbours, in metres; None if no block has a neighbour.

    counts: number of steps by size in units   mean: sum |dh| / n   rms: sqrt(sum dh^2 / n)
    """

    unit: float
    counts: dict[int, int]
    mean: float | None
    rms: float | None
    highest: float | None

    def share_above(self, limit: float) -> float | None:
        """The share of the steps above a limit in metres, P(|dh| > limit)."""
        if not self.counts:
            return None
        above = sum(count for step, count in self.counts.items() if round((step * self.unit - limit) * NANOMETRES) > 0)
        return above / sum(self.counts.values())


def steps(field: StepField) -> Steps:
    """The steps of a field; two blocks with a frame between them are not neighbours."""
    found = np.bincount(differences(field))
    if not len(found):
        return Steps(unit=field.unit, counts={}, mean=None, rms=None, highest=None)
    sizes, share = np.arange(len(found)), found / found.sum()
    return Steps(
        unit=field.unit,
        counts={int(size): int(found[size]) for size in np.flatnonzero(found)},
        mean=float(sizes @ share) * field.unit,
        rms=float(np.sqrt(sizes**2 @ share)) * field.unit,
        highest=float(sizes[-1]) * field.unit,
    )
