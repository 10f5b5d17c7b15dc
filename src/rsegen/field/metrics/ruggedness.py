"""How rugged it is round each block."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from rsegen.field.metrics.pairs import differences
from rsegen.field.stepfield import StepField


@dataclass(frozen=True, kw_only=True, slots=True)
class Ruggedness:
    """Of the `cells` blocks with 8 blocks around them, in metres; None where there is none.

    tri: mean of sqrt(sum (h_k - h_0)^2 / 8), the root-mean form   riley: mean of sqrt(sum (h_k - h_0)^2), Riley's own
    surface_ratio: tops and risers over the plan, 1 + sum |dh| / (N w); the rim of the field is left out
    """

    cells: int
    tri: float | None
    riley: float | None
    surface_ratio: float


def ruggedness(field: StepField) -> Ruggedness:
    """The ruggedness of a field, and its surface."""
    riley = _riley(field)
    risers = int(differences(field).sum()) * field.unit
    return Ruggedness(
        cells=riley.size,
        tri=float(riley.mean() / np.sqrt(8)) if riley.size else None,
        riley=float(riley.mean()) if riley.size else None,
        surface_ratio=1 + risers / (int((~field.frame).sum()) * field.block_width),
    )


def _riley(field: StepField) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """sqrt(sum (h_k - h_0)^2) of every block with 8 blocks around it, metres, as one row."""
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
