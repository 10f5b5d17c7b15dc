"""Measured lengths as those of lumber that is sold."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rsegen.params.numbers import DRESSED
from rsegen.scanning.lumber import alternatives, dressed_inches, sold_length


@pytest.mark.parametrize("sold", [0.0381, 0.0635, 0.075, 0.0889, 0.09, 0.095, 0.1, 0.05])
@pytest.mark.parametrize("off", [-0.003, -0.001, 0, 0.001, 0.003])
def test_posts_that_are_measured_within_a_third_of_a_per_cent_have_their_own_width(sold: float, off: float) -> None:
    assert sold_length(sold * (1 + off)) == sold


def test_other_lengths_are_whole_millimetres() -> None:
    assert [sold_length(metres) for metres in (0.0852, 0.0127, 0.0012)] == [0.085, 0.013, 0.001]
    assert sold_length(0.0871) == 0.087


def test_half_a_post_is_a_unit_of_half_cubic_blocks() -> None:
    assert sold_length(0.0445, (0.0889, 0.0889 / 2)) == 0.04445
    assert sold_length(0.0445) == 0.045


def test_other_lumber_that_is_nearly_as_wide_is_known() -> None:
    assert list(alternatives(0.0890, 0.0889)) == [0.09]
    assert list(alternatives(0.0899, 0.09)) == [0.0889]
    assert list(alternatives(0.1, 0.1)) == []
    assert dressed_inches(0.0889) == 3.5
    assert dressed_inches(0.09) is None


@given(st.floats(0.002, 2))
def test_a_length_is_off_by_little(metres: float) -> None:
    assert abs(sold_length(metres) - metres) <= max(0.015 * metres, 0.0005 + 1e-9)


@given(st.sampled_from(sorted(DRESSED)))
def test_dressed_lumber_is_itself(inches: float) -> None:
    assert sold_length(inches * 0.0254) == round(inches * 0.0254, 6)
