"""Lengths, weights and cuts of timber as people read them, in metric units or in units of the USA and Canada.

Timber is sold by the metre, or by the foot and by the name of its section (`DRESSED`).
"""

from __future__ import annotations

from dataclasses import asdict, dataclass

from rsegen.params.numbers import DRESSED, TAPE_MARKS, Lengths, decimal, lengths_in

_POUND = 0.45359237
"""Kilograms of a pound, exactly (1959)."""

_CUBIC_FOOT = 0.3048**3
"""Cubic metres of a cubic foot, exactly."""


@dataclass(frozen=True, kw_only=True, slots=True)
class TimberLengths(Lengths):
    """A unit of lengths, the units of timber and of the kerf, and how many nanometres they have."""

    timber: str
    timber_size: int
    kerf: str
    kerf_size: int

    def at_least(self, length: int) -> str:
        """Return a length in nanometres with its unit, rounded up to the next mark of a tape measure."""
        mark = self.size // TAPE_MARKS if self.unit == "in" else 1
        return f"{self.tape(-(-length // mark) * mark)} {self.unit}"

    def stock(self, length: int) -> str:
        """Return the length of a piece of timber with its unit, as it is sold: 240 cm, 8 ft."""
        if self.unit == "in" and length % self.timber_size == 0:
            return f"{length // self.timber_size} {self.timber}"
        return f"{self.tape(length)} {self.unit}"

    def section(self, sides: tuple[int, int]) -> str:
        """Return two sides in nanometres as the name of the lumber that has them, such as 2x4; empty if none has."""
        names = [DRESSED.get(side / self.size) for side in sorted(sides)] if self.unit == "in" else [None]
        return "" if None in names else "x".join(map(str, names))

    def long(self, length: int) -> str:
        """Return a length in nanometres as a length of timber, rounded to hundredths, halves up."""
        hundredth = self.timber_size // 100
        return f"{(length + hundredth // 2) // hundredth / 100:,.2f} {self.timber}"

    def weight(self, kilograms: float) -> str:
        """Return a weight in kilograms or pounds."""
        return f"{kilograms / _POUND:,.0f} lb" if self.unit == "in" else f"{kilograms:,.0f} kg"

    def density(self, density: float) -> str:
        """Return a density in kg/m3 with its unit."""
        return f"{density * _CUBIC_FOOT / _POUND:.0f} lb/ft3" if self.unit == "in" else f"{density:g} kg/m3"

    def cut(self, length: int) -> str:
        """Return a kerf in nanometres with its unit."""
        marks = length * TAPE_MARKS / self.kerf_size
        if self.unit == "in" and marks and abs(marks - round(marks)) < 1e-3:
            return f"{self.tape(length)} {self.kerf}"
        return f"{decimal(round(length / self.kerf_size, 4))} {self.kerf}"


def timber_lengths_in(units: str) -> TimberLengths:
    """Return the units of lengths of timber for `units` of a recipe: cm or in."""
    own = asdict(lengths_in(units))
    if units == "in":
        return TimberLengths(**own, timber="ft", timber_size=304_800_000, kerf="in", kerf_size=25_400_000)
    return TimberLengths(**own, timber="m", timber_size=10**9, kerf="mm", kerf_size=10**6)
