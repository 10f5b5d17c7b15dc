"""From timber to blocks: how many pieces of stock they are sawn from, and how each piece is cut.

Lengths are whole nanometres, so that twelve blocks of 20 cm are 240 cm and not a little more.
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
    """What the blocks are sawn with and from."""

    kerf_mm: Annotated[float, Float(0, 100, unit="mm", help="width that the saw takes away at every cut")] = 3.0
    stock_cm: Annotated[float, Float(0.001, 100_000, unit="cm", help="length of the timber that is bought")] = 240.0

    def __post_init__(self) -> None:
        validate(self)

    @property
    def kerf(self) -> int:
        """Nanometres."""
        return round(self.kerf_mm * 1e6)

    @property
    def stock(self) -> int:
        """Nanometres."""
        return nanometres(self.stock_cm)

    def check(self, length_cm: float, what: str = "the longest block") -> None:
        """Raise a ParameterError where the stock is too short for a length."""
        if nanometres(length_cm) > self.stock:
            given, longest = decimal(self.stock_cm), decimal(length_cm)
            raise ParameterError("stock_cm", f"{given} is shorter than {what}, {longest} cm; give {longest} or more")


@dataclass(frozen=True, kw_only=True, slots=True)
class Pattern:
    """So many pieces of stock that are cut alike: into `parts`, length and number; `room` is what else fits in.

    A part takes its length and a kerf, the stock has a kerf more than its length: after the last part that ends with
    the stock nothing is sawn.
    """

    pieces: int
    parts: tuple[tuple[int, int], ...]
    room: int

    def offcut(self, settings: CutSettings) -> int:
        """What is left of a piece, nanometres."""
        return max(0, self.room - settings.kerf)


@dataclass(frozen=True, kw_only=True, slots=True)
class CuttingPlan:
    """How the blocks are sawn; lengths in nanometres."""

    settings: CutSettings
    patterns: Sequence[Pattern]

    @property
    def pieces(self) -> int:
        """Pieces of stock to buy."""
        return sum(pattern.pieces for pattern in self.patterns)

    @property
    def timber(self) -> int:
        """In the blocks themselves."""
        return sum(pattern.pieces * length * count for pattern in self.patterns for length, count in pattern.parts)

    @property
    def offcuts(self) -> int:
        """What is left over of all pieces."""
        return sum(pattern.pieces * pattern.offcut(self.settings) for pattern in self.patterns)

    @property
    def kerf_loss(self) -> int:
        """What the saw takes away."""
        return self.pieces * self.settings.stock - self.timber - self.offcuts


def nanometres(length_cm: float) -> int:
    """A length in centimetres."""
    return round(length_cm * 1e7)


def centimetres(length: int) -> str:
    """A length in nanometres, with as many digits as it needs."""
    return decimal(length / 1e7)


def plan_cuts(counts: Mapping[int, int], settings: CutSettings) -> CuttingPlan:
    """So many parts of each length [nm], first fit decreasing: the longest first, each into the first with room."""
    patterns: list[Pattern] = []
    for length in sorted(counts, reverse=True):
        settings.check(length / 1e7)
        fresh = Pattern(pieces=counts[length], parts=(), room=settings.stock + settings.kerf)
        filled = _filled([*patterns, fresh], length, counts[length], settings.kerf)
        patterns = [pattern for pattern in filled if pattern.parts]
    return CuttingPlan(settings=settings, patterns=tuple(patterns))


def _filled(patterns: Sequence[Pattern], length: int, count: int, kerf: int) -> Iterator[Pattern]:
    """The same pieces in their order; each takes as many more parts as fit, until there are no more."""
    for pattern in patterns:
        most = pattern.room // (length + kerf)
        full = min(pattern.pieces, count // most) if most else 0
        last = min(count - full * most, most) if full < pattern.pieces else 0
        count -= full * most + last
        untouched = pattern.pieces - full - bool(last)
        for pieces, parts in ((full, most), (int(bool(last)), last), (untouched, 0)):
            if pieces:
                yield _cut(replace(pattern, pieces=pieces), length, parts, kerf)


def _cut(pattern: Pattern, length: int, count: int, kerf: int) -> Pattern:
    if not count:
        return pattern
    return replace(pattern, parts=(*pattern.parts, (length, count)), room=pattern.room - count * (length + kerf))
