"""Lengths with their unit."""

from __future__ import annotations

import pytest

from rsegen.errors import ParameterError
from rsegen.params.sorts import Float, Integer, ListOf, with_lengths

CM, MM = Float(0, 100, unit="cm"), Float(0, 100, unit="mm")


@pytest.mark.parametrize(
    ("text", "parameter", "number"),
    [
        ("3.5in", CM, "8.89"),
        ("8 ft", CM, "243.84"),
        ("38mm", CM, "3.8"),
        ("0.1m", CM, "10.0"),
        (".125in", MM, "3.175"),
        ("1/8in", MM, "3.175"),
        ("2 29/32 in", CM, "7.381875"),
        ("1/0in", MM, "1/0in"),
        ("5", CM, "5"),
        ("4in,8in,2cm", ListOf(CM, 3), "10.16,20.32,2.0"),
        ("burger", ListOf(CM, 3), "burger"),
        ("3in", Integer(0, 9), "3in"),
        ("1e-3", CM, "1e-3"),
        ("3inches", CM, "3inches"),
    ],
)
def test_a_length_becomes_a_number_of_its_parameter_s_unit(text: str, parameter: Float, number: str) -> None:
    assert with_lengths(text, parameter, "k") == number


def test_in_inches_a_length_without_a_unit_is_refused() -> None:
    assert with_lengths("3.5in", CM, "k", units="in") == "8.89"
    assert with_lengths("7", Integer(0, 9), "k", units="in") == "7"
    with pytest.raises(ParameterError, match=r"unit_cm: '3\.5' has no unit; with units in write 3\.5in or 3\.5cm"):
        with_lengths("3.5", CM, "unit_cm", units="in")
