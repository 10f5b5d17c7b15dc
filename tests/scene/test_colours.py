"""The colour of a height reads without colour, on every map, with any text on it; levels are told apart."""

from __future__ import annotations

from itertools import pairwise
from math import dist

import pytest
from hypothesis import given
from hypothesis import strategies as st

import rsegen
from rsegen import Random, Recipe
from rsegen.scene.colours import Colour, height_colour, oklab
from tests.page.browser.pages import maps_of

HEIGHTS = st.floats(0, 100)
NOTICED = 0.02
"""A distance in OKLab that people see between two large areas."""


def luminance(colour: Colour) -> float:
    """Relative luminance as WCAG 2 has it."""
    red, green, blue = (part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in colour)
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


@given(HEIGHTS, HEIGHTS)
def test_a_higher_block_is_lighter(one: float, other: float) -> None:
    low, high = sorted((one, other))
    assert luminance(height_colour(low)) <= luminance(height_colour(high)) + 1e-9


@pytest.mark.parametrize(
    ("step", "most"),
    [(0.003, 0.012), (0.005, 0.02), (0.01, 0.07), (0.02, 0.14), (0.025, 0.25), (0.05, 0.5), (0.1, 0.9), (0.2, 1.4)],
)
def test_neighbouring_levels_are_told_apart(step: float, most: float) -> None:
    colours = [oklab(height_colour(level * step, most)) for level in range(round(most / step) + 1)]
    assert all(dist(low, high) > NOTICED for low, high in pairwise(colours))


@given(HEIGHTS)
def test_black_or_white_text_is_legible_on_every_height(height: float) -> None:
    ground = luminance(height_colour(height))
    assert max((ground + 0.05) / 0.05, 1.05 / (ground + 0.05)) >= 4.5


@pytest.mark.parametrize(
    ("colour", "lab"),
    [((1, 1, 1), (1, 0, 0)), ((1, 0, 0), (0.62796, 0.22486, 0.12585)), ((0, 0, 1), (0.45201, -0.03246, -0.31153))],
)
def test_primary_colours_are_where_css_has_them_in_oklab(colour: Colour, lab: tuple[float, float, float]) -> None:
    assert oklab(colour) == pytest.approx(lab, abs=1e-4)


@pytest.mark.parametrize(
    ("height", "colour"),
    [(0, (0.22, 0.2, 0.42)), (0.0875, (0.17, 0.38, 0.6)), (0.525, (0.45, 0.74, 0.38)), (1.4, (0.95, 0.84, 0.29))],
)
def test_fifths_of_the_ramp_are_its_own_colours(height: float, colour: Colour) -> None:
    # Of the middle of 35 cm, 1/4, 3/2 and 4 times are 1/5, 3/5 and 4/5 of the ramp.
    assert height_colour(height) == pytest.approx(colour, abs=1e-3)


def test_a_height_has_one_colour_on_all_standard_maps() -> None:
    found: dict[float, set[str]] = {}
    for unit, levels in ((10, 3), (5, 9), (20, 2)):
        (shown,) = maps_of(rsegen.view(Recipe(seed=1, unit_cm=unit, obstacles=[Random(levels=levels)])).html)
        for entry in shown["palette"]:
            if entry["level"] is not None:
                found.setdefault(entry["height"], set()).add(entry["colour"])
    assert len(found) > 5
    assert all(len(colours) == 1 for colours in found.values())
