"""A metric."""

from __future__ import annotations

import numpy as np

import rsegen


@rsegen.metric(unit="of all pairs")
def flat_share(field: rsegen.StepField) -> float:
    """Share of the pairs of neighbouring cells, frames counted, that have the same height."""
    steps = [np.diff(field.heights, axis=axis).ravel() for axis in (0, 1)]
    return float(np.mean(np.concatenate(steps) == 0))
