"""Colours of tilt, margin, cost and reach, which nobody takes for heights."""

from __future__ import annotations

from colorsys import rgb_to_hsv

import numpy as np
import pytest

from rsegen.pictures.plan import ramp
from rsegen.scene.colours import height_colour

SHARES = np.linspace(0, 1, 50)


def test_no_height_has_a_colour_of_the_ramp() -> None:
    heights = np.array([height_colour(centimetres / 100) for centimetres in range(1, 200)])
    # Pale ends of two ramps may be near each other in distance, but not in hue.
    ours = ramp()(SHARES)[:, :3]
    distances = np.linalg.norm(heights[:, None] - ours[None], axis=2)
    assert distances.min() > 0.15
    hues = [rgb_to_hsv(*colour)[0] * 360 for colour in ours]
    assert min(hues) > 290


def test_it_falls_in_lightness_and_turns_around() -> None:
    lightness = ramp()(SHARES)[:, :3] @ (0.299, 0.587, 0.114)
    assert (np.diff(lightness) < 0).all()
    assert lightness[0] > 0.9
    assert lightness[-1] < 0.25
    assert ramp(reverse=True)(SHARES)[::-1] == pytest.approx(ramp()(SHARES), abs=0.02)
