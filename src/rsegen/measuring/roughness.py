"""Roughness: steps between neighbours, spread of heights, deviation from a plane, ruggedness, and growth with distance.

Nearly all of it is made of level differences between blocks some cells apart, without frames; docs/metrics.md has every
formula with its source. Cost: linear in the cells, for `scale` once per lag. Sums are taken over levels, integers or
shares of counts, and units are multiplied at the end.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from rsegen.field.stepfield import Array, StepField
from rsegen.field.steps import differences


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
    """Return the height distribution of a field's blocks."""
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


@dataclass(frozen=True, kw_only=True, slots=True)
class Plane:
    """The plane of least squares through the tops h of the blocks, at their middles: h = a + b x + c y.

    residual: sqrt(mean (h - plane)^2), metres; what a slope alone explains is not in it   slope: sqrt(b^2 + c^2)
    """

    residual: float
    slope: float


def plane(field: StepField) -> Plane:
    """Return the plane of a field; blocks in one line, or one block, have the plane of the least slope."""
    places = np.argwhere(~field.frame).T.astype(np.float64)
    places -= places.mean(axis=1, keepdims=True)
    heights = field.levels[~field.frame] - field.levels[~field.frame].mean()
    # Of centred places the squares are a 2 x 2 matrix, singular if all blocks are in one line.
    gradient = np.linalg.pinv(places @ places.T, rcond=1e-9, hermitian=True) @ (places @ heights)
    return Plane(
        residual=float(np.sqrt(np.mean((heights - gradient @ places) ** 2))) * field.unit,
        slope=float(np.hypot(*gradient)) * field.unit / field.block_width,
    )


@dataclass(frozen=True, kw_only=True, slots=True)
class Ruggedness:
    """The ruggedness over the `cells` blocks with 8 neighbouring blocks, in metres; None without such blocks.

    tri: mean of sqrt(sum (h_k - h_0)^2 / 8), the root-mean form   riley: mean of sqrt(sum (h_k - h_0)^2), Riley's own
    surface_ratio: area of tops and risers over that of the plan, 1 + sum |dh| / (N w), without the field's border
    """

    cells: int
    tri: float | None
    riley: float | None
    surface_ratio: float


def ruggedness(field: StepField) -> Ruggedness:
    """Return the ruggedness and the surface ratio of a field."""
    riley = _riley(field)
    risers = int(differences(field).sum()) * field.unit
    return Ruggedness(
        cells=riley.size,
        tri=float(riley.mean() / np.sqrt(8)) if riley.size else None,
        riley=float(riley.mean()) if riley.size else None,
        surface_ratio=1 + risers / (int((~field.frame).sum()) * field.block_width),
    )


def _riley(field: StepField) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Return sqrt(sum (h_k - h_0)^2) of every block with 8 neighbouring blocks, metres, shape (n,)."""
    n_x, n_y = field.shape
    if min(n_x, n_y) < 3:
        return np.empty(0)
    levels = field.levels.astype(float)
    middle = levels[1:-1, 1:-1]
    squares = np.zeros(middle.shape)
    for i, j in product(range(3), range(3)):  # the block itself adds 0
        squares += (levels[i : n_x - 2 + i, j : n_y - 2 + j] - middle) ** 2
    whole = ~sliding_window_view(field.frame, (3, 3)).any(axis=(2, 3))
    return np.asarray(np.sqrt(squares[whole]) * field.unit)


LAGS = 24
"""Number of lags, at the most. They are logarithmically spaced, as the exponent is a slope of logarithms; more of them
on a large map add time and hardly change the slope."""

FEW = 10
"""Lags below which a fitted exponent is marked as weak: fields of up to some 20 blocks per side."""


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
    """Return the scale of a field: lags up to half of its shorter side, beyond which pairs are few and overlap."""
    largest = min(field.blocks.shape) // 2
    lags = np.unique(np.rint(np.geomspace(1, largest, LAGS)).astype(int)) if largest else np.array([], dtype=int)
    pairs = [(int(lag), gaps) for lag in lags if len(gaps := differences(field, int(lag)))]
    cells = np.array([lag for lag, _ in pairs], dtype=float)
    rms = np.array([np.sqrt(np.mean(np.square(gaps, dtype=float))) for _, gaps in pairs])
    return Scale(
        lags=tuple((cells * field.block_width).tolist()),
        rms=tuple((rms * field.unit).tolist()),
        hurst=exponent(cells, rms),
        hurst_is_weak=len(cells) < FEW,
    )


def exponent(x: Array, y: Array) -> float | None:
    """Return p of y ~ x^p, by least squares on the logarithms; None for fewer than two places, or a value of 0."""
    if len(x) < 2 or not y.all():
        return None
    along = np.log(x) - np.log(x).mean()
    return float(along @ np.log(y) / (along @ along))
