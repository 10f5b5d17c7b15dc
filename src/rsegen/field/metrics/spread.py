"""The distribution of heights, regardless of their positions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rsegen.field.stepfield import StepField


@dataclass(frozen=True, kw_only=True, slots=True)
class Spread:
    """The distribution of the N heights h of the blocks, in metres; p is the share of a level.

    deviation: sqrt(sum (h - mean)^2 / N)   variation: deviation / mean, None if flat   entropy: -sum p log2 p, bits
    """

    level_counts: dict[int, int]
    lowest: float
    highest: float
    mean: float
    deviation: float
    variation: float | None
    entropy: float


def spread(field: StepField) -> Spread:
    """The height distribution of a field's blocks."""
    level_counts = field.level_counts()
    levels, counts = (np.array(list(part), dtype=float) for part in (level_counts, level_counts.values()))
    share = counts / counts.sum()
    mean = float(levels @ share)
    deviation = float(np.sqrt((levels - mean) ** 2 @ share))
    return Spread(
        level_counts=level_counts,
        lowest=float(levels[0]) * field.unit,
        highest=float(levels[-1]) * field.unit,
        mean=mean * field.unit,
        deviation=deviation * field.unit,
        variation=deviation / mean if mean else None,
        entropy=abs(float(share @ np.log2(share))),
    )
