"""The figures of Team Hector's model of a pallet, computed apart from rsegen, to the last digit; in units of 10 cm."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
import pytest

import rsegen
from rsegen import Metrics, StepField
from rsegen.recipe.examples import EXAMPLES

PALLET = rsegen.build(rsegen.load(EXAMPLES["red-diagonal-pallet"]))
HALVES = np.where(PALLET.levels == 0, 1, 2 * PALLET.levels).astype(np.int16)
POSTS = replace(PALLET, levels=np.where(PALLET.frame, np.int16(0), HALVES), unit=PALLET.unit / 2)
"""As it stands in the arenas: its shortest posts are half a unit long."""

FIGURES: Mapping[str, tuple[Callable[[Metrics], float | None], str, str]] = {
    "mean height": (lambda found: found.spread.mean, "1.960", "2.005"),
    "standard deviation": (lambda found: found.spread.deviation, "1.113", "1.040"),
    "mean step": (lambda found: found.steps.mean, "1.128", "1.044"),
    "rms step": (lambda found: found.steps.rms, "1.302", "1.221"),
    "highest step": (lambda found: found.steps.highest, "2.000", "2.000"),
    "mean TRI, root-mean form": (lambda found: found.ruggedness.tri, "1.308", "1.231"),
}


@pytest.mark.parametrize(("figure", "ground", "posts"), FIGURES.values(), ids=FIGURES)
def test_a_length_of_the_pallet_in_units(figure: Callable[[Metrics], float | None], ground: str, posts: str) -> None:
    found = [figure(rsegen.metrics(field)) for field in (PALLET, POSTS)]
    assert [f"{value / PALLET.unit:.3f}" for value in found if value is not None] == [ground, posts]


@pytest.mark.parametrize(
    ("field", "variation", "surface", "rms", "posts"),
    [
        (PALLET, "0.568", "3.03", "1.302 1.481 1.558 1.668 1.697", 19.6),
        (POSTS, "0.519", "2.88", "1.221 1.413 1.451 1.582 1.595", 20.05),
    ],
    ids=["ground", "posts"],
)
def test_the_pallet_s_other_figures(field: StepField, variation: str, surface: str, rms: str, posts: float) -> None:
    found = rsegen.metrics(field)
    assert f"{found.spread.variation:.3f}" == variation
    assert f"{found.ruggedness.surface_ratio:.2f}" == surface
    assert " ".join(f"{value / PALLET.unit:.3f}" for value in found.scale.rms) == rms
    assert sum(level * count for level, count in found.spread.level_counts.items()) * field.unit == pytest.approx(posts)


def test_the_pallet_s_counts() -> None:
    found = rsegen.metrics(PALLET)
    assert found.spread.level_counts == {0: 9, 1: 27, 2: 33, 3: 21, 4: 10}
    assert found.steps.counts == {0: 28, 1: 101, 2: 51}
    assert found.ruggedness.cells == 64
    assert found.scale.lags == pytest.approx((0.1, 0.2, 0.3, 0.4, 0.5))


def test_the_pallet_s_exponent_is_0_17_and_weak() -> None:
    found = rsegen.metrics(PALLET).scale
    assert f"{found.hurst:.2f}" == "0.17"
    assert found.hurst_is_weak


def test_the_pallet_opens_at_one_unit_both_ways() -> None:
    """Every ridge post has a shoulder of 3 units on either side somewhere; the frame is one unit high."""
    found = rsegen.metrics(PALLET).opening
    assert (found.west_east, found.south_north) == (0.1, 0.1)
