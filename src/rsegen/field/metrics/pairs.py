"""Pairs of blocks some cells apart."""

from __future__ import annotations

import numpy as np

from rsegen.field.stepfield import Ints, StepField


def differences(field: StepField, lag: int = 1) -> Ints:
    """|difference| in levels of any two blocks `lag` cells apart along x or y, both ends in no frame: one row."""
    levels, block = field.levels.astype(np.int32), ~field.frame
    return np.concatenate(
        [np.abs(h[lag:] - h[:-lag])[b[lag:] & b[:-lag]] for h, b in ((levels, block), (levels.T, block.T))]
    )
