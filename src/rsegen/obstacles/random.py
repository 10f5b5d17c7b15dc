"""The random profile of the paper's figure 4."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import accumulate
from typing import Annotated, Any, ClassVar

import numpy as np

from rsegen.errors import ParameterError, shown
from rsegen.obstacles.base import Obstacle, Region, register
from rsegen.params import Json, Real
from rsegen.stepfield import Array, Levels


@dataclass(frozen=True)
class Weights:
    """A weight for each level, lowest first: any numbers from 0 on, not all of them 0."""

    help: str = ""

    def check(self, where: str, value: object) -> tuple[float, ...]:
        if not isinstance(value, (list, tuple)) or not value:
            raise ParameterError(where, f"{shown(value)} is not a list of weights; give {self.describe()}")
        weights = tuple(Real(0, 1e12).check(f"{where}[{level}]", one) for level, one in enumerate(value))
        if not any(weights):
            raise ParameterError(where, "all weights are 0; give at least one above 0")
        return weights

    def parse(self, text: str) -> object:
        return [Real().parse(part) for part in text.split(",")]

    def spell(self, value: Any) -> str:
        return ",".join(map(str, value))

    def schema(self) -> dict[str, Json]:
        return {"type": "array", "items": Real(0, 1e12).schema(), "minItems": 1}

    def describe(self) -> str:
        return "one number from 0 on for each level, lowest level first, as in [1, 2, 2, 1, 1]"


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Random(Region):
    """Every cell drawn by itself, all levels equally likely or as `weights` says; softness scales it down."""

    kind: ClassVar[str] = "random"

    weights: Annotated[
        tuple[float, ...] | None, Weights(help="how often each level should come, in any scale; default: all alike")
    ] = None

    def __post_init__(self) -> None:
        Obstacle.__post_init__(self)
        if self.weights is not None and len(self.weights) != self.max_height:
            raise ParameterError(
                "weights", f"{len(self.weights)} weights for {self.max_height} levels; give one for each level"
            )

    def drawn(self, uniform: Array) -> Levels:
        """floor(n f) with f = u (1 - s/100); with weights, the level whose share of [0, 1) holds f."""
        f = uniform * (1 - self.softness / 100)
        if self.weights is None:
            return np.floor(self.max_height * f).astype(np.int16)
        shares = np.array(list(accumulate(self.weights))) / math.fsum(self.weights)
        top = max(level for level, weight in enumerate(self.weights) if weight)
        return np.minimum(np.searchsorted(shares, f, side="right"), top).astype(np.int16)
