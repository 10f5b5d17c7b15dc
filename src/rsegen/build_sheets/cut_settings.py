"""Settings for buying and cutting timber, of a build sheet, in the units of a workshop."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from rsegen.build_sheets.timber_lengths import timber_lengths_in
from rsegen.errors import ParameterError
from rsegen.params.numbers import decimal
from rsegen.params.sorts import Float, validate


def nanometres(length_cm: float) -> int:
    """Return a length in centimetres as whole nanometres."""
    return round(length_cm * 1e7)


@dataclass(frozen=True, kw_only=True, slots=True)
class CutSettings:
    """Settings for buying and cutting timber: the saw, the stock and its ends, play in frames, weight and prices."""

    kerf_mm: Annotated[
        float,
        Float(
            0,
            100,
            unit="mm",
            usual=(0, 10),
            help="width that the saw removes with every cut; 1/8 in with units in",
        ),
    ] = 3.0
    stock_cm: Annotated[
        float, Float(0.001, 100_000, unit="cm", help="length of the pieces of timber to buy; 8 ft with units in")
    ] = 240.0
    trim_cm: Annotated[
        float,
        Float(0, 1000, unit="cm", usual=(0, 10), help="cut off at each end of a piece of stock; 1/2 in with units in"),
    ] = 1.0
    tolerance_mm: Annotated[
        float,
        Float(0, 100, unit="mm", usual=(0, 5), help="how much too long a part may be cut; 1/32 in with units in"),
    ] = 0.5
    play_mm: Annotated[
        float, Float(0, 1000, unit="mm", usual=(0, 10), help="clearance of a row of blocks in its frame")
    ] = 0.0
    density: Annotated[float, Float(1, 10_000, unit="kg/m3", help="density of the timber; pine: about 500")] = 500.0
    price: Annotated[float | None, Float(0, 1e9, help="price of a piece of stock for blocks; default: no cost")] = None
    frame_price: Annotated[
        float | None,
        Float(
            0, 1e9, help="price of a piece of stock for frames; default: as for blocks, if they are cut from the same"
        ),
    ] = None

    def __post_init__(self) -> None:
        validate(self)
        if self.usable <= 0:
            raise ParameterError("trim_cm", f"nothing is left of {decimal(self.stock_cm)} cm of stock; use less")

    @classmethod
    def default(cls, units: str) -> CutSettings:
        """Return the default settings in a recipe's units: metric, or inches and feet."""
        return cls(stock_cm=243.84, kerf_mm=3.175, trim_cm=1.27, tolerance_mm=0.79375) if units == "in" else cls()

    @property
    def kerf(self) -> int:
        """Length that the saw removes with each cut, in nanometres."""
        return round(self.kerf_mm * 1e6)

    @property
    def tolerance(self) -> int:
        """Length by which each part may be too long, in nanometres."""
        return round(self.tolerance_mm * 1e6)

    @property
    def stock(self) -> int:
        """The stock length in nanometres."""
        return nanometres(self.stock_cm)

    @property
    def trim(self) -> int:
        """Length that both ends of a piece of stock lose together, in nanometres."""
        return 2 * nanometres(self.trim_cm)

    @property
    def usable(self) -> int:
        """The length of a piece of stock without its ends, in nanometres."""
        return self.stock - self.trim

    @property
    def play(self) -> int:
        """The play in nanometres."""
        return round(self.play_mm * 1e6)

    def fits(self, length: int) -> bool:
        """Return whether a part of a length [nm] can be cut from the stock, also if it is cut too long."""
        return length + self.tolerance <= self.usable

    def least_stock(self, length: int) -> int:
        """Return the length of the shortest stock from which a part of a length can be cut, both in nanometres."""
        return length + self.trim + self.tolerance

    def check(self, length: int, what: str, units: str) -> None:
        """Raise a ParameterError, in the units of a recipe, if the stock is too short for a part of a length [nm]."""
        if not self.fits(length):
            written = timber_lengths_in(units)
            problem = f"{written.tape(self.stock)} {written.unit} is too short for {what}, {written.tape(length)}"
            least = written.at_least(self.least_stock(length))
            raise ParameterError("stock_cm", f"{problem} {written.unit}; use {least} or more")
