"""The cutting plan: how many pieces of stock the blocks need, and how each piece is cut.

Lengths are whole nanometres, so that twelve blocks of 20 cm are exactly 240 cm.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated

from rsegen.errors import ParameterError
from rsegen.exporters.numbers import decimal
from rsegen.params.sorts import Float, validate


@dataclass(frozen=True, kw_only=True, slots=True)
class CutSettings:
    """The kerf of the saw and the length of the stock that blocks are cut from."""

    kerf_mm: Annotated[
        float,
        Float(0, 100, unit="mm", help="width of material that the saw removes with every cut; 1/8 in with units in"),
    ] = 3.0
    stock_cm: Annotated[
        float, Float(0.001, 100_000, unit="cm", help="length of the pieces of timber to buy; 8 ft with units in")
    ] = 240.0

    def __post_init__(self) -> None:
        validate(self)

    @classmethod
    def default(cls, units: str) -> CutSettings:
        """Those of a recipe's units: 240 cm and 3 mm, or 8 ft and 1/8 in."""
        return cls(stock_cm=243.84, kerf_mm=3.175) if units == "in" else cls()

    @property
    def kerf(self) -> int:
        """The kerf in nanometres."""
        return round(self.kerf_mm * 1e6)

    @property
    def stock(self) -> int:
        """The stock length in nanometres."""
        return nanometres(self.stock_cm)

    def check(self, length_cm: float, what: str = "the longest block") -> None:
        """Raise a ParameterError if the stock is too short for a length."""
        if nanometres(length_cm) > self.stock:
            given, longest = decimal(self.stock_cm), decimal(length_cm)
            raise ParameterError("stock_cm", f"{given} is shorter than {what}, {longest} cm; give {longest} or more")


@dataclass(frozen=True, kw_only=True, slots=True)
class Pattern:
    """Pieces of stock that are cut alike, into `parts` (length, number); `room` is the length that is still free.

    A part takes its length and a kerf, and the stock counts as a kerf longer: a last part that ends with the stock
    needs no cut.
    """

    pieces: int
    parts: tuple[tuple[int, int], ...]
    room: int

    def offcut(self, settings: CutSettings) -> int:
        """The offcut of each piece in nanometres."""
        return max(0, self.room - settings.kerf)


@dataclass(frozen=True, kw_only=True, slots=True)
class CuttingPlan:
    """The patterns that all blocks are cut by; lengths in nanometres."""

    settings: CutSettings
    patterns: Sequence[Pattern]

    @property
    def pieces(self) -> int:
        """The number of pieces of stock to buy."""
        return sum(pattern.pieces for pattern in self.patterns)

    @property
    def timber(self) -> int:
        """The length of all blocks together."""
        return sum(pattern.pieces * length * count for pattern in self.patterns for length, count in pattern.parts)

    @property
    def offcuts(self) -> int:
        """The length of all offcuts together."""
        return sum(pattern.pieces * pattern.offcut(self.settings) for pattern in self.patterns)

    @property
    def kerf_loss(self) -> int:
        """The length that the saw removes."""
        return self.pieces * self.settings.stock - self.timber - self.offcuts


def nanometres(length_cm: float) -> int:
    """A length in centimetres as whole nanometres."""
    return round(length_cm * 1e7)


def plan_cuts(counts: Mapping[int, int], settings: CutSettings) -> CuttingPlan:
    """The cutting plan for a number of parts of each length [nm], by the first-fit-decreasing rule."""
    patterns: list[Pattern] = []
    for length in sorted(counts, reverse=True):
        settings.check(length / 1e7)
        fresh = Pattern(pieces=counts[length], parts=(), room=settings.stock + settings.kerf)
        filled = _filled([*patterns, fresh], length, counts[length], settings.kerf)
        patterns = [pattern for pattern in filled if pattern.parts]
    return CuttingPlan(settings=settings, patterns=tuple(patterns))


def _filled(patterns: Sequence[Pattern], length: int, count: int, kerf: int) -> Iterator[Pattern]:
    """The patterns in order, each filled with as many parts of one length as fit, until `count` are placed."""
    for pattern in patterns:
        most = pattern.room // (length + kerf)
        full = min(pattern.pieces, count // most) if most else 0
        last = min(count - full * most, most) if full < pattern.pieces else 0
        count -= full * most + last
        unchanged = pattern.pieces - full - bool(last)
        for pieces, parts in ((full, most), (int(bool(last)), last), (unchanged, 0)):
            if pieces:
                yield _cut(replace(pattern, pieces=pieces), length, parts, kerf)


def _cut(pattern: Pattern, length: int, count: int, kerf: int) -> Pattern:
    if not count:
        return pattern
    return replace(pattern, parts=(*pattern.parts, (length, count)), room=pattern.room - count * (length + kerf))
