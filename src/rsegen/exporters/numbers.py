"""Numbers as text: the one format of everything that rsegen writes, and lengths for people.

Files have metres as plain decimals to the nanometre (`decimal`). Build sheets, warnings and summaries have lengths in
centimetres and metres, or in inches and feet (`Lengths`), computed from whole nanometres, so that 3.5 in is 3.5 in.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

from rsegen.params.sorts import NANOMETRE_DIGITS


@lru_cache(maxsize=2**14)
def decimal(value: float) -> str:
    """Return a plain decimal to the nanometre, without trailing zeros: 0.3, -1.25, 0."""
    text = f"{value:.{NANOMETRE_DIGITS}f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


_POUND = 0.45359237
"""Kilograms of a pound, exactly (1959)."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Lengths:
    """The units of lengths, of timber and of the kerf, with their nanometres.

    name: of the first, in a sentence; digits: its decimals
    """

    unit: str
    name: str
    size: int
    digits: int
    timber: str
    timber_size: int
    kerf: str
    kerf_size: int

    def short(self, length: int) -> str:
        """Return a length in nanometres in the unit, without its name."""
        return decimal(round(length / self.size, self.digits))

    def level(self, level: int, unit_cm: float) -> str:
        """Return the height of a level in the unit, without its name."""
        return self.short(round(level * unit_cm * 1e7))

    def long(self, length: int) -> str:
        """Return a length in nanometres as a length of timber, rounded to hundredths, halves up."""
        hundredth = self.timber_size // 100
        return f"{(length + hundredth // 2) // hundredth / 100:,.2f} {self.timber}"

    def weight(self, kilograms: float) -> str:
        """Return a weight in kilograms or pounds."""
        return f"{kilograms / _POUND:,.0f} lb" if self.unit == "in" else f"{kilograms:,.0f} kg"

    def cut(self, length: int) -> str:
        """Return a kerf in nanometres with its unit."""
        return f"{decimal(round(length / self.kerf_size, 4))} {self.kerf}"


_METRIC = Lengths(unit="cm", name="cm", size=10**7, digits=7, timber="m", timber_size=10**9, kerf="mm", kerf_size=10**6)
_INCHES = Lengths(
    unit="in",
    name="inches",
    size=25_400_000,
    digits=3,
    timber="ft",
    timber_size=304_800_000,
    kerf="in",
    kerf_size=25_400_000,
)


def lengths_in(units: str) -> Lengths:
    """Return the units of lengths for `units` of a recipe: cm or in."""
    return _INCHES if units == "in" else _METRIC
