"""Terrain ruggedness: height differences between each block and its 8 neighbours."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from rsegen.field.metrics.pairs import differences
from rsegen.field.stepfield import StepField


@dataclass(frozen=True, kw_only=True, slots=True)
class Ruggedness:
    """The ruggedness over the `cells` blocks with 8 neighbouring blocks, in metres; None if there are none.

    tri: mean of sqrt(sum (h_k - h_0)^2 / 8), the root-mean form   riley: mean of sqrt(sum (h_k - h_0)^2), Riley's own
    surface_ratio: area of tops and risers over that of the plan, 1 + sum |dh| / (N w), without the field's border
    """

    cells: int
    tri: float | None
    riley: float | None
    surface_ratio: float


def ruggedness(field: StepField) -> Ruggedness:
    """The ruggedness and the surface ratio of a field."""
    riley = _riley(field)
    risers = int(differences(field).sum()) * field.unit
    return Ruggedness(
        cells=riley.size,
        tri=float(riley.mean() / np.sqrt(8)) if riley.size else None,
        riley=float(riley.mean()) if riley.size else None,
        surface_ratio=1 + risers / (int((~field.frame).sum()) * field.block_width),
    )


def _riley(field: StepField) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """sqrt(sum (h_k - h_0)^2) of every block with 8 neighbouring blocks, metres, shape (n,)."""
    n_x, n_y = field.shape
    if min(n_x, n_y) < 3:
        return np.empty(0)
    levels = field.levels.astype(float)
    middle = levels[1:-1, 1:-1]
    squares = np.zeros(middle.shape)
    for i, j in product(range(3), range(3)):
        squares += (levels[i : n_x - 2 + i, j : n_y - 2 + j] - middle) ** 2
    whole = ~sliding_window_view(field.frame, (3, 3)).any(axis=(2, 3))
    return np.asarray(np.sqrt(squares[whole]) * field.unit)
