"""Lengths as people read them: of a metric tape, or of one with fractions of an inch."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rsegen.params.numbers import lengths_in

INCH, MARK = 25_400_000, 793_750
INCHES, METRIC = lengths_in("in"), lengths_in("cm")


@pytest.mark.parametrize(
    ("length", "text"),
    [(3.5 * INCH, "3 1/2"), (14 * INCH, "14"), (93 * MARK, "2 29/32"), (5 * MARK, "5/32"), (0, "0"), (254_000, "0.01")],
)
def test_a_tape_has_fractions_of_an_inch(length: float, text: str) -> None:
    assert INCHES.tape(round(length)) == text


@given(st.integers(MARK, 10**13))
def test_a_tape_is_off_by_half_a_mark_at_most(length: int) -> None:
    read = sum((Fraction(part) for part in INCHES.tape(length).split()), Fraction())
    assert abs(read * INCH - length) <= Fraction(MARK, 2)
    assert read.denominator <= 32


@given(st.integers(0, 10**13))
def test_a_metric_tape_has_decimals(length: int) -> None:
    assert METRIC.tape(length) == METRIC.short(length)
