"""An ellipse of friction stands for a box: it contains it, and what slips is held as by the box."""

from __future__ import annotations

from math import hypot

import pytest

from rsegen.mujoco.friction import MOST_RATIO, corner_ellipse

SLIPS = [(0.0, 0.0), (0.3, 0.0), (0.0, 0.3), (0.3, 0.3), (0.5, 0.05), (-0.02, 0.2), (1e-4, -1e-3)]


@pytest.mark.parametrize("slip", SLIPS)
@pytest.mark.parametrize(("mu", "mu2"), [(0.5, 0.5), (1.0, 0.3), (0.01, 0.5)])
def test_an_ellipse_meets_the_corners_of_its_box(mu: float, mu2: float, slip: tuple[float, float]) -> None:
    half, half2 = corner_ellipse(mu, mu2, *slip)
    assert (mu / half) ** 2 + (mu2 / half2) ** 2 == pytest.approx(1)
    assert mu < half <= mu * (1 + MOST_RATIO) ** 0.5 + 1e-12
    assert mu2 < half2 <= mu2 * (1 + MOST_RATIO) ** 0.5 + 1e-12


@pytest.mark.parametrize("slip", [(0.3, 0.3), (0.5, 0.05), (-0.05, 0.2)])
def test_what_slips_both_ways_is_held_with_the_whole_friction_of_each(slip: tuple[float, float]) -> None:
    """The force of an ellipse against a slip is where its tangent is at right angles to the slip."""
    mu, mu2 = 0.5, 0.4
    half, half2 = corner_ellipse(mu, mu2, *slip)
    size = hypot(half * slip[0], half2 * slip[1])
    assert half**2 * abs(slip[0]) / size == pytest.approx(mu, rel=1e-4)
    assert half2**2 * abs(slip[1]) / size == pytest.approx(mu2, rel=1e-4)


def test_what_slips_along_alone_is_held_along_as_before() -> None:
    half, half2 = corner_ellipse(0.5, 0.5, 0.4, 0.0)
    assert half == pytest.approx(0.5, rel=0.03)
    assert half2 == pytest.approx(2.5, rel=0.01)
