"""Limits of steps: the largest one up and down on a path of cells, and its width; no robot, as nothing stands or tips.

And the bounds within which the size and the speeds of any robot are.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from rsegen.field.crossing import CrossingModel
from rsegen.params.sorts import NANOMETRES, Float, validate

if TYPE_CHECKING:
    from rsegen.field.stepfield import Ints, StepField
    from rsegen.field.traversability import Crossing, Traversability

# Centimetres to a hundred metres, and a millimetre per second to 360 km/h: all robots, and no model in millimetres.
SIDE = Float(0.01, 100, unit="m")
SPEED, TURN = Float(0.001, 100, unit="m/s"), Float(0.001, 100, unit="rad/s")
"""Bounds of a robot's size, speed and turn rate, whether a flag gives them or an SDF file."""


@dataclass(frozen=True, kw_only=True, slots=True)
class StepLimits(CrossingModel):
    """Limits of a path from cell to cell: steps of up to `climb_cm` up and `drop_cm` down, `width_cm` wide."""

    climb_cm: Annotated[float, Float(0, 100_000, unit="cm", help="highest step up on a path of cells")]
    drop_cm: Annotated[float | None, Float(0, 100_000, unit="cm", help="highest step down; default: as climb")] = None
    width_cm: Annotated[
        float, Float(0, 100_000, unit="cm", help="width of the path, whose highest cell counts; 0: one cell")
    ] = 0.0

    def __post_init__(self) -> None:
        validate(self)

    @classmethod
    def of(cls, climb: float, width: float) -> StepLimits:
        """Return the limits of a climb and a width in metres."""
        return cls(climb_cm=round(climb * 100, 7), width_cm=round(width * 100, 7))

    @property
    def limits(self) -> tuple[int, int]:
        """Highest step up and highest step down, nanometres."""
        climb_cm, drop_cm, _ = self.climb_drop_width
        return round(climb_cm * NANOMETRES / 100), round(drop_cm * NANOMETRES / 100)

    @property
    def climb_drop_width(self) -> tuple[float, float, float]:
        """Climb, drop and width in centimetres."""
        return self.climb_cm, self.climb_cm if self.drop_cm is None else self.drop_cm, self.width_cm

    @property
    def width(self) -> float:
        """Width in metres."""
        return self.width_cm / 100

    def reach(self, field: StepField) -> Traversability:
        """Return the traversability of a field within these limits."""
        from rsegen.field.traversability import traversability

        return traversability(field, self)

    def crossing(self, field: StepField, axis: int) -> Crossing:
        """Return the cheapest path across a field, along x for axis 0, along y for axis 1."""
        from rsegen.field.traversability import crossing

        return crossing(field, self, axis)

    def caps(self, field: StepField, axis: int) -> Ints | None:
        """Return the highest levels along the cheapest path of the least highest step; None if one leads across."""
        from rsegen.field.traversability import path_caps

        return path_caps(field, self, axis)

    def in_words(self, units: str) -> str:
        """Return the limits in words; units: of lengths, as in recipes."""
        from rsegen.params.numbers import lengths_in

        written = lengths_in(units)
        up, down = (f"{written.short(limit)} {written.unit}" for limit in self.limits)
        wide = f", {written.with_unit(self.width, 3)} wide" if self.width_cm else ""
        return f"a path of steps of up to {up} up and {down} down{wide}"
