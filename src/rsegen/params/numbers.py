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
    rounded = f"{degrees(angle):.0f}"
    return f"{rounded} degree{'' if rounded == '1' else 's'}"


def counted(count: int, what: str) -> str:
    """Return a count of things in words: 1 file, 1,200 files."""
    return f"{count:,} {what}{'' if count == 1 else 's'}"


DRESSED: Mapping[float, int] = MappingProxyType({0.75: 1, 1.5: 2, 2.5: 3, 3.5: 4, 5.5: 6, 7.25: 8, 9.25: 10, 11.25: 12})
"""Nominal inches by which lumber is sold in the USA and Canada, by the inches that it has when it is dry and planed
(American Softwood Lumber Standard, PS 20)."""

TAPE_MARKS = 32
"""Parts of an inch on a tape measure, the finest that a saw keeps to: the usual tolerance of a part is one of them."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Lengths:
    """A unit of lengths: its name in a sentence, its nanometres, and its decimals."""

    unit: str
    name: str
    size: int
    digits: int

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
        marks = round(length * TAPE_MARKS / self.size)
        if self.unit != "in" or not marks:  # what is thinner than a mark is better a decimal than nothing
            return self.short(length)
        whole, part = divmod(marks, TAPE_MARKS)
        return " ".join(filter(None, (str(whole) * bool(whole), str(Fraction(part, TAPE_MARKS)) * bool(part))))

    def level(self, level: int, unit_cm: float) -> str:
        """Return the height of a level in the unit, without its name."""
        return self.short(round(level * unit_cm * 1e7))


_METRIC = Lengths(unit="cm", name="cm", size=10**7, digits=7)
_INCHES = Lengths(unit="in", name="inches", size=25_400_000, digits=3)


def lengths_in(units: str) -> Lengths:
    """Return the unit of lengths for `units` of a recipe: cm or in."""
    return _INCHES if units == "in" else _METRIC
