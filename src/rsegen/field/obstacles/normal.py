"""The normal random kind: slightly smoother than the random kind."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from rsegen.field.obstacles.base import Region, register
from rsegen.field.stepfield import Array, Levels
from rsegen.params.sorts import Float


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class NormalRandom(Region):
    """Random blocks with normally distributed heights, each cell independent; softness scales them down."""

    kind: ClassVar[str] = "normal_random"

    spread: Annotated[float, Float(0.001, 100, help="standard deviation, as a share of the full height")] = 0.2

    def drawn(self, uniform: Array) -> Levels:
        """floor(n f) with f = clip(0.5 + z spread, 0, 1 - eps) (1 - s/100) and z = the normal quantile of `uniform`.

        Computed by the inverse, which needs no quantile per cell: f reaches level k if u >= P(z < z_k).
        """
        scale = self.max_height * (1 - self.softness / 100)
        levels = range(1, math.ceil(scale))
        bounds = [_normal_cdf((level / scale - 0.5) / self.spread) for level in levels]
        return np.searchsorted(np.array(bounds), uniform, side="right").astype(np.int16)


def _normal_cdf(z: float) -> float:
    """P(Z < z), rounded, so that math libraries that differ in the last bit give the same levels."""
    return round(0.5 * math.erfc(-z / math.sqrt(2)), 12)
