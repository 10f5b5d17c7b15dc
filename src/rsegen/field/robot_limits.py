"""A robot as the metrics see it: how far up and down it gets in one step, and how wide it is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from rsegen.field.stepfield import StepField
from rsegen.params.sorts import Float, validate

NANOMETRES = 10**9
"""In a metre: heights that are compared with limits are whole numbers of them."""


@dataclass(frozen=True, kw_only=True, slots=True)
class RobotLimits:
    """It gets up a step of up to `climb_cm` and down one of up to `drop_cm`."""

    climb_cm: Annotated[float, Float(0, 100_000, unit="cm", help="highest step that the robot gets up")]
    drop_cm: Annotated[
        float | None,
        Float(0, 100_000, unit="cm", help="highest step that it gets down unharmed; by default what it climbs"),
    ] = None
    width_cm: Annotated[
        float, Float(0, 100_000, unit="cm", help="its width: it stands on the highest of the cells below; 0: one cell")
    ] = 0.0

    def __post_init__(self) -> None:
        validate(self)

    @classmethod
    def of(cls, climb: float, width: float) -> RobotLimits:
        """The same from metres."""
        return cls(climb_cm=round(climb * 100, 7), width_cm=round(width * 100, 7))

    @property
    def limits(self) -> tuple[int, int]:
        """The highest step up and the highest step down, nanometres."""
        climb_cm, drop_cm, _ = self.figures
        return round(climb_cm * NANOMETRES / 100), round(drop_cm * NANOMETRES / 100)

    @property
    def figures(self) -> tuple[float, float, float]:
        """Climb, drop and width, centimetres."""
        return self.climb_cm, self.climb_cm if self.drop_cm is None else self.drop_cm, self.width_cm

    @property
    def width(self) -> float:
        """Metres."""
        return self.width_cm / 100


def cells_aside(field: StepField, width: float) -> int:
    """How many cells lie under a robot of that width to each side of its middle, which is on a cell's middle."""
    aside = np.ceil(round((width / field.block_width - 1) / 2, 6))
    return int(np.clip(aside, 0, max(field.shape)))
