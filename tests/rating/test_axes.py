"""Axes: levels make fields harder, and come back from their places."""

from __future__ import annotations

from dataclasses import replace
from math import atan, degrees, inf

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rsegen
from rsegen.errors import ParameterError
from rsegen.params.command import declared
from rsegen.rating.axes import AXES, Axis, refuse_unusable
from rsegen.rating.rate import usual_fields

FIELDS = replace(usual_fields(), seed=5)


def rms_step(recipe: rsegen.Recipe) -> float:
    """Return the root mean square of the steps along x of the first field, metres."""
    return float(np.sqrt((np.diff(rsegen.build(recipe).levels.astype(float), axis=0) ** 2).mean())) * recipe.unit_cm


@pytest.mark.parametrize("axis", AXES.values(), ids=AXES)
def test_every_candidate_is_a_level_of_three_digits_that_a_recipe_takes(axis: Axis) -> None:
    levels = [axis.tried(place) for place in axis.candidates]
    assert len(set(levels)) == len(levels) > 100
    for level in levels[:: len(levels) // 20]:
        assert axis.low <= level <= axis.high
        assert f"{level:.3g}" == f"{level:g}"
        assert axis.level(axis.place(level)) == pytest.approx(level)
        assert axis.recipe_at(FIELDS, level).seed == FIELDS.seed
    assert (np.diff(axis.candidates) > 0).all()


@pytest.mark.parametrize("name", ["unit", "difficulty", "slope"])
@given(share=st.floats(0.02, 0.9))
def test_harder_levels_make_higher_steps(name: str, share: float) -> None:
    axis = AXES[name]
    easier, harder = (
        axis.level(axis.ends[0] + part * (axis.ends[1] - axis.ends[0])) for part in (share, min(share + 0.1, 1))
    )
    steps = [rms_step(axis.recipe_at(FIELDS, level)) for level in (easier, harder)]
    assert steps[0] <= steps[1]


def test_narrower_blocks_are_the_harder_ones() -> None:
    axis = AXES["block_width"]
    assert axis.place(5) > axis.place(20)
    assert axis.level(axis.ends[0]) == pytest.approx(axis.high)


def test_a_slope_is_that_of_one_unit_per_block() -> None:
    recipe = AXES["slope"].recipe_at(replace(FIELDS, block_width_cm=20), 30)
    assert degrees(atan(recipe.unit_cm / 20)) == pytest.approx(30, abs=0.01)


def test_axes_are_those_of_the_command() -> None:
    assert declared(rsegen.rate)["axis"].words == tuple(AXES)


def test_fields_that_no_level_changes_are_refused() -> None:
    with pytest.raises(ParameterError, match="recipe: has no obstacle, so its fields are flat"):
        refuse_unusable(AXES["unit"], rsegen.Recipe(seed=1))
    with pytest.raises(ParameterError, match=r"recipe: has difficulty 0\.5; leave it at 1"):
        refuse_unusable(AXES["difficulty"], replace(FIELDS, difficulty=0.5))


@pytest.mark.parametrize("axis", AXES.values(), ids=AXES)
def test_levels_beyond_an_axis_are_infinite_or_zero_and_said_to_be_beyond(axis: Axis) -> None:
    first, last = axis.ends
    assert axis.level_within((first + last) / 2) == axis.level((first + last) / 2)
    lower, higher = (first - 0.1, last + 0.1) if axis.is_rising else (last + 0.1, first - 0.1)
    assert (axis.level_within(lower), axis.level_within(higher)) == (0, inf)
    words = axis.shown(axis.high / 2, 0, inf)
    assert words.endswith(f"[less than {axis.low:g}, more than {axis.high:g}]")
    assert axis.shown(inf) == axis.words.format(f"more than {axis.high:g}")
