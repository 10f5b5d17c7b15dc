"""Timber as it is sold: by the foot, and by the name of its section."""

from __future__ import annotations

from rsegen.build_sheets.timber_lengths import timber_lengths_in
from rsegen.params.numbers import DRESSED

INCH, MARK = 25_400_000, 793_750
INCHES, METRIC = timber_lengths_in("in"), timber_lengths_in("cm")


def test_lumber_is_named_by_its_nominal_section() -> None:
    for side, nominal in DRESSED.items():
        assert INCHES.section((round(side * INCH), round(3.5 * INCH))) == "x".join(map(str, sorted((nominal, 4))))
    assert INCHES.section((90_000_000, 90_000_000)) == METRIC.section((88_900_000, 88_900_000)) == ""


def test_stock_is_sold_by_the_foot() -> None:
    assert INCHES.stock(96 * INCH) == "8 ft"
    assert INCHES.stock(92 * INCH + 20 * MARK) == "92 5/8 in"
    assert METRIC.stock(2_400_000_000) == "240 cm"


def test_weights_and_densities_in_inches_are_in_pounds() -> None:
    """Water has 62.4 lb per cubic foot."""
    assert (INCHES.density(1000), METRIC.density(1000)) == ("62 lb/ft3", "1000 kg/m3")
    assert (INCHES.weight(1000), METRIC.weight(1000)) == ("2,205 lb", "1,000 kg")
