"""Level differences between blocks that are some cells apart."""

from __future__ import annotations

import numpy as np

from rsegen.field.stepfield import Ints, StepField


def differences(field: StepField, lag: int = 1) -> Ints:
    """|difference| in levels of all pairs of blocks `lag` cells apart along x or y, without frames, shape (n,)."""
    levels, block = field.levels.astype(np.int32), ~field.frame
    return np.concatenate(
        [np.abs(h[lag:] - h[:-lag])[b[lag:] & b[:-lag]] for h, b in ((levels, block), (levels.T, block.T))]
    )
