"""Properties of the metrics of every field, and fields small enough to be worked out by hand."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import rsegen
from rsegen import StepField
from rsegen.errors import ParameterError
from rsegen.measuring.roughness import FEW, LAGS
from tests.support.strategies import fields


def field(*rows: str, unit: float = 0.1, frame_height: float = 0.1) -> StepField:
    """A field as one sees it, north up: a digit is a level, # a frame."""
    cells = np.array([list(row) for row in rows])[::-1].T
    frame = cells == "#"
    levels = np.where(frame, "0", cells).astype(np.int16)
    return StepField(levels=levels, frame=frame, block_width=0.1, unit=unit, frame_height=frame_height)


def turned(found: StepField) -> StepField:
    """A quarter turn."""
    return replace(found, levels=np.rot90(found.levels).copy(), frame=np.rot90(found.frame).copy())


@given(fields())
def test_metrics_agree_with_a_loop_over_cells(found: StepField) -> None:
    assume(not found.frame.all())
    result = rsegen.metrics(found)
    blocks = {(i, j): found.levels[i, j] * found.unit for i, j in np.argwhere(~found.frame).tolist()}
    heights = np.array(list(blocks.values()))
    assert result.spread.mean == pytest.approx(heights.mean())
    assert result.spread.deviation == pytest.approx(heights.std())
    gaps = [abs(blocks[a] - blocks[b]) for a, b in combinations(blocks, 2) if abs(a[0] - b[0]) + abs(a[1] - b[1]) == 1]
    assert sum(result.steps.counts.values()) == len(gaps)
    assert result.steps.mean == (pytest.approx(np.mean(gaps)) if gaps else None)
    assert result.steps.highest == (pytest.approx(max(gaps)) if gaps else None)
    ratio = 1 + found.block_width * sum(gaps) / (len(blocks) * found.block_width**2)
    assert result.ruggedness.surface_ratio == pytest.approx(ratio)


@given(fields())
def test_a_quarter_turn_changes_no_metric_of_the_blocks_and_swaps_the_openings(found: StepField) -> None:
    assume(not found.frame.all())
    one, other = rsegen.metrics(found), rsegen.metrics(turned(found))
    assert one.spread == other.spread
    assert one.steps == other.steps
    assert one.scale.rms == pytest.approx(other.scale.rms)
    assert one.ruggedness.tri == pytest.approx(other.ruggedness.tri)
    assert (one.opening.west_east, one.opening.south_north) == (other.opening.south_north, other.opening.west_east)


@given(fields(), st.integers(2, 5))
def test_higher_units_scale_every_length(found: StepField, times: int) -> None:
    assume(not found.frame.all())
    one, high = rsegen.metrics(found), rsegen.metrics(replace(found, unit=found.unit * times))
    assert high.spread.deviation == pytest.approx(one.spread.deviation * times)
    assert high.steps.rms == (None if one.steps.rms is None else pytest.approx(one.steps.rms * times))
    assert high.spread.entropy == one.spread.entropy
    assert high.scale.hurst == (None if one.scale.hurst is None else pytest.approx(one.scale.hurst))


def test_a_ramp_grows_as_fast_as_it_is_long() -> None:
    """Along x it rises by the lag, along y not at all: v(L) = L / sqrt 2, and H = 1."""
    ramp = field(*["0123456789"] * 10)
    found = rsegen.metrics(ramp)
    assert found.scale.hurst == pytest.approx(1)
    assert found.scale.rms[0] == pytest.approx(0.1 / np.sqrt(2))


def test_a_checkerboard_has_one_bit_and_steps_only() -> None:
    found = rsegen.metrics(field("101", "010", "101"))
    assert found.steps.counts == {1: 12}
    assert found.steps.share_above(0.1) == 0
    assert found.steps.share_above(0.0999) == 1
    assert found.ruggedness.tri == pytest.approx(0.1 * np.sqrt(4 / 8))
    assert found.ruggedness.riley == pytest.approx(0.1 * 2)
    assert rsegen.metrics(field("10", "01")).spread.entropy == 1


def test_blocks_on_two_sides_of_a_frame_are_no_neighbours() -> None:
    assert rsegen.metrics(field("0##4")).steps.counts == {}
    assert rsegen.metrics(field("0##4")).steps.share_above(0.1) is None


def test_ground_alone_has_neither_variation_nor_exponent() -> None:
    found = rsegen.metrics(field("0000", "0000", "0000", "0000"))
    assert (found.spread.variation, found.scale.hurst, found.spread.entropy) == (None, None, 0)


def test_one_block_alone_has_metrics() -> None:
    found = rsegen.metrics(field("3"), rsegen.StepLimits(climb_cm=30))
    assert (found.steps.mean, found.ruggedness.tri, found.scale.lags) == (None, None, ())
    assert found.opening.west_east == pytest.approx(0.3)
    assert found.reach is not None
    assert found.reach.coverage == 1


def test_a_large_map_has_lags_enough_for_an_exponent() -> None:
    levels = np.random.default_rng(1).integers(0, 5, (200, 100)).astype(np.int16)
    large = replace(field("0"), levels=levels, frame=np.zeros(levels.shape, dtype=bool))
    found = rsegen.metrics(large).scale
    assert FEW < len(found.lags) <= LAGS
    assert not found.hurst_is_weak
    assert found.hurst == pytest.approx(0, abs=0.01)  # what is drawn cell by cell does not grow with distance


def test_frames_alone_cannot_be_measured() -> None:
    with pytest.raises(ParameterError, match="field: has only frame cells"):
        rsegen.metrics(field("##", "##"))
