"""The smaller coefficient counts; an ellipse of friction stands for a box: what slips is held as by the box."""

from __future__ import annotations

from math import hypot

import mujoco
import pytest

from rsegen.mujoco.friction import LEAST, MOST_RATIO, MapFriction, corner_ellipse

SLIPS = [(0.0, 0.0), (0.3, 0.0), (0.0, 0.3), (0.3, 0.3), (0.5, 0.05), (-0.02, 0.2), (1e-4, -1e-3)]
FREE = (0.0, 0.0)
"""Nothing of the friction is spent."""


@pytest.mark.parametrize("slips", SLIPS)
@pytest.mark.parametrize("spent", [FREE, (1.0, 1.0), (1.3, 0.2)])
@pytest.mark.parametrize("halves", [(0.5, 0.5), (1.0, 0.3), (0.01, 0.5)])
def test_an_ellipse_meets_the_corners_of_its_box(
    halves: tuple[float, float], spent: tuple[float, float], slips: tuple[float, float]
) -> None:
    (mu, mu2), (half, half2) = halves, corner_ellipse(halves, slips, spent)
    assert (mu / half) ** 2 + (mu2 / half2) ** 2 == pytest.approx(1)
    assert mu < half <= mu * (1 + MOST_RATIO) ** 0.5 + 1e-12
    assert mu2 < half2 <= mu2 * (1 + MOST_RATIO) ** 0.5 + 1e-12


@pytest.mark.parametrize("slips", [(0.3, 0.3), (0.5, 0.05), (-0.05, 0.2)])
@pytest.mark.parametrize("spent", [FREE, (1.0, 1.0)])
def test_what_slips_both_ways_is_held_with_the_whole_friction_of_each(
    spent: tuple[float, float], slips: tuple[float, float]
) -> None:
    """The force of an ellipse against a slip is where its tangent is at right angles to the slip."""
    mu, mu2 = 0.5, 0.4
    half, half2 = corner_ellipse((mu, mu2), slips, spent)
    size = hypot(half * slips[0], half2 * slips[1])
    assert half**2 * abs(slips[0]) / size == pytest.approx(mu, rel=0.06)
    assert half2**2 * abs(slips[1]) / size == pytest.approx(mu2, rel=0.06)


def test_what_slips_along_alone_is_held_along_as_before() -> None:
    half, half2 = corner_ellipse((0.5, 0.5), (0.4, 0.0), FREE)
    assert half == pytest.approx(0.5, rel=0.03)
    assert half2 == pytest.approx(2.5, rel=0.01)


@pytest.mark.parametrize(("share", "share2"), [(1.0, 0.5), (1.1, 0.8), (0.95, 0.0)])
def test_what_is_held_begins_to_slip_at_the_side_of_the_box_that_is_nearer(share: float, share2: float) -> None:
    mu, mu2 = 0.5, 1.0
    half, half2 = corner_ellipse((mu, mu2), (0.0, 1e-5), (share, share2))  # it creeps
    size = hypot(share * mu / half, share2 * mu2 / half2)
    assert size >= 0.96 * share, "so much of this force is too much"
    other, other2 = corner_ellipse((mu2, mu), (1e-5, 0.0), (share2, share))
    assert (other, other2) == pytest.approx((half2, half))


@pytest.mark.parametrize("mu", [0.0, 0.1, 0.2, 0.35, 0.5, 0.9, 1.5])
@pytest.mark.parametrize("of_map", [(0.5,), (0.2, 0.5, 0.9)])
def test_a_shape_touches_each_part_of_a_map_once_with_the_smaller_coefficient(
    mu: float, of_map: tuple[float, ...]
) -> None:
    friction = MapFriction(of_map)
    layers = list(friction.layers(mu))
    spheres = "".join(
        f'<geom type="sphere" size="0.1" friction="{own}" priority="{priority}" contype="{bits}" conaffinity="0"/>'
        for priority, own, bits in layers
    )
    for other in of_map:
        part = f'<geom type="plane" size="1 1 1" friction="{other}" contype="0" conaffinity="{friction.bit(other)}"/>'
        body = f'<body pos="0 0 0.099"><freejoint/>{spheres}</body>'
        model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{part}{body}</worldbody></mujoco>")
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        assert data.contact.friction[:, 0] == pytest.approx([max(min(mu, other), LEAST)])
