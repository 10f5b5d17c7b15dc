"""Steps: the height differences of neighbouring blocks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rsegen.field.stepfield import Ints, StepField
from rsegen.params.sorts import NANOMETRES


def differences(field: StepField, lag: int = 1) -> Ints:
    """Return |difference| in levels of all pairs of blocks `lag` cells apart along x or y, without frames, (n,)."""
    levels, block = field.levels.astype(np.int32), ~field.frame
    return np.concatenate(
        [np.abs(h[lag:] - h[:-lag])[b[lag:] & b[:-lag]] for h, b in ((levels, block), (levels.T, block.T))]
    )


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
        """Return the share of the steps above a limit in metres, P(|dh| > limit)."""
        if not self.counts:
            return None
        above = sum(count for step, count in self.counts.items() if round((step * self.unit - limit) * NANOMETRES) > 0)
        return above / sum(self.counts.values())


def steps(field: StepField) -> Steps:
    """Return the steps of a field; two blocks with a frame between them are not neighbours."""
    counts = np.bincount(differences(field))
    if not len(counts):
        return Steps(unit=field.unit, counts={}, mean=None, rms=None, highest=None)
    sizes, share = np.arange(len(counts)), counts / counts.sum()
    return Steps(
        unit=field.unit,
        counts={int(size): int(counts[size]) for size in np.flatnonzero(counts)},
        mean=float(sizes @ share) * field.unit,
        rms=float(np.sqrt(sizes**2 @ share)) * field.unit,
        highest=float(sizes[-1]) * field.unit,
    )
