"""Roughness by scale: how height differences grow with distance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rsegen.field.metrics.pairs import differences
from rsegen.field.stepfield import Array, Ints, StepField

LAGS = 24
"""The maximum number of lags, which are logarithmically spaced."""
FEW = 10
"""An exponent that is fitted to fewer lags is marked as weak."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Scale:
    """The rms difference v(L) = sqrt(mean (h(x + L) - h(x))^2) of blocks L apart along x or y, in metres.

    lags, rms: L and v(L)   hurst: H of v ~ L^H, by least squares on the logarithms; None for fewer than two lags
    """

    lags: tuple[float, ...]
    rms: tuple[float, ...]
    hurst: float | None
    hurst_is_weak: bool


def scale(field: StepField) -> Scale:
    """The scale of a field: lags up to half of its shorter side, beyond which pairs are few and overlap."""
    lags = _lags(min(field.blocks.shape) // 2)
    found = [(int(lag), gaps) for lag in lags if len(gaps := differences(field, int(lag)))]
    cells = np.array([lag for lag, _ in found], dtype=float)
    rms = np.array([np.sqrt(np.mean(np.square(gaps, dtype=float))) for _, gaps in found])
    return Scale(
        lags=tuple((cells * field.block_width).tolist()),
        rms=tuple((rms * field.unit).tolist()),
        hurst=_exponent(cells, rms),
        hurst_is_weak=len(cells) < FEW,
    )


def _lags(largest: int) -> Ints:
    return np.unique(np.rint(np.geomspace(1, largest, LAGS)).astype(int)) if largest else np.array([], dtype=int)


def _exponent(lags: Array, rms: Array) -> float | None:
    """The slope of log v over log L."""
    if len(lags) < 2 or not rms.all():
        return None
    x, y = np.log(lags) - np.log(lags).mean(), np.log(rms)
    return float(x @ y / (x @ x))
