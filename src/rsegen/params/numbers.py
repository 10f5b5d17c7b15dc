"""Numbers as text: the one format of everything that rsegen writes, and lengths for people.

Files have metres as plain decimals to the nanometre (`decimal`). Build sheets, warnings and summaries have lengths in
centimetres and metres, or in inches and feet (`Lengths`), computed from whole nanometres, so that 3.5 in is 3.5 in.
What is cut is written as a tape measure shows it (`Lengths.tape`): 3 1/2 in.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from math import degrees
from types import MappingProxyType

from rsegen.params.sorts import NANOMETRE_DIGITS


@lru_cache(maxsize=2**14)
def decimal(value: float) -> str:
    """Return a plain decimal to the nanometre, without trailing zeros: 0.3, -1.25, 0."""
    text = f"{value:.{NANOMETRE_DIGITS}f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def whole_degrees(angle: float) -> str:
    """Return an angle in radians as people say it: 1 degree, 2 degrees."""
    number = f"{degrees(angle):.0f}"
    return f"{number} degree{'' if number == '1' else 's'}"


_POUND = 0.45359237
"""Kilograms of a pound, exactly (1959)."""

_CUBIC_FOOT = 0.3048**3
"""Cubic metres of a cubic foot, exactly."""

DRESSED: Mapping[float, int] = MappingProxyType({0.75: 1, 1.5: 2, 2.5: 3, 3.5: 4, 5.5: 6, 7.25: 8, 9.25: 10, 11.25: 12})
"""Nominal inches by which lumber is sold in the USA and Canada, by the inches that it has when it is dry and planed
(American Softwood Lumber Standard, PS 20)."""

_TAPE = 32
"""Parts of an inch on a tape measure, the finest that a saw keeps to: the usual tolerance of a part is one of them."""


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

    @property
    def per_metre(self) -> float:
        """Units in a metre: 100 of centimetres."""
        return 1e9 / self.size

    def short(self, length: int) -> str:
        """Return a length in nanometres in the unit, without its name."""
        return decimal(round(length / self.size, self.digits))

    def measured(self, metres: float | None, digits: int = 2) -> str:
        """Return a measured length, rounded to some decimals of the unit, without its name; a dash for none."""
        return "-" if metres is None else decimal(round(metres * 1e9 / self.size, digits) + 0)

    def with_unit(self, metres: float | None, digits: int = 2) -> str:
        """Return a measured length with its unit, rounded to some decimals of it."""
        return f"{self.measured(metres, digits)} {self.unit}"

    def tape(self, length: int) -> str:
        """Return a length in nanometres as a tape measure shows it, without its unit: 10.5 of cm, 2 29/32 of inches."""
        marks = round(length * _TAPE / self.size)
        if self.unit != "in" or not marks:  # what is thinner than a mark is better a decimal than nothing
            return self.short(length)
        whole, rest = divmod(marks, _TAPE)
        return " ".join(filter(None, (str(whole) * bool(whole), str(Fraction(rest, _TAPE)) * bool(rest))))

    def at_least(self, length: int) -> str:
        """Return the least length that a tape measure shows and that is not below one in nanometres, with its unit."""
        mark = self.size // _TAPE if self.unit == "in" else 1
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

    def density(self, density: float) -> str:
        """Return a density in kg/m3 with its unit."""
        return f"{density * _CUBIC_FOOT / _POUND:.0f} lb/ft3" if self.unit == "in" else f"{density:g} kg/m3"

    def cut(self, length: int) -> str:
        """Return a kerf in nanometres with its unit."""
        marks = length * _TAPE / self.kerf_size
        if self.unit == "in" and marks and abs(marks - round(marks)) < 1e-3:
            return f"{self.tape(length)} {self.kerf}"
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
