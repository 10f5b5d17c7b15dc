"""Planes and spectra are those of numpy's least squares and of scipy's periodogram, on any field."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.signal import periodogram

import rsegen
from rsegen import StepField
from rsegen.field.stepfield import Array, framed
from rsegen.measuring.roughness import plane
from rsegen.measuring.spectrum import ProfileSpectrum, spectrum
from tests.support.strategies import fields


def bare(levels: NDArray[Any], unit: float = 0.1) -> StepField:
    """A field without frames."""
    levels = np.asarray(levels, dtype=np.int16)
    frame = np.zeros(levels.shape, dtype=bool)
    return StepField(levels=levels, frame=frame, block_width=0.1, unit=unit, frame_height=0.1)


@given(fields())
def test_the_plane_is_that_of_numpy_s_least_squares(found: StepField) -> None:
    assume(not found.frame.all())
    i, j = np.nonzero(~found.frame)
    x, y, h = i * found.block_width, j * found.block_width, found.levels[i, j] * found.unit
    columns = np.stack([np.ones(len(i)), x - x.mean(), y - y.mean()], axis=1)
    solved = np.linalg.lstsq(columns, h, rcond=1e-9)[0]
    result = plane(found)
    assert result.residual == pytest.approx(np.sqrt(np.mean((h - columns @ solved) ** 2)), abs=1e-9)
    assert result.slope == pytest.approx(np.hypot(*solved[1:]), abs=1e-9)


@given(st.integers(0, 4), st.integers(0, 4), st.tuples(st.integers(1, 9), st.integers(1, 9)))
def test_a_ramp_is_its_own_plane(along_x: int, along_y: int, shape: tuple[int, int]) -> None:
    i, j = np.indices(shape)
    result = plane(bare(along_x * i + along_y * j))
    assert result.residual == pytest.approx(0, abs=1e-9)
    rises = [rise if cells > 1 else 0 for rise, cells in zip((along_x, along_y), shape, strict=True)]
    assert result.slope == pytest.approx(math.hypot(*rises))


@given(fields())
def test_the_residual_is_between_nothing_and_the_standard_deviation(found: StepField) -> None:
    assume(not found.frame.all())
    result = rsegen.metrics(found)
    assert 0 <= result.plane.residual <= result.spread.deviation + 1e-9


def judged(profiles: NDArray[Any], width: float) -> tuple[Array, Array]:
    """Frequencies and mean density of profiles (n, profiles) by scipy, without zero and an even number's highest."""
    frequencies, density = periodogram(profiles, fs=1 / width, window="hann", detrend="linear", axis=0)
    kept = slice(1, (len(profiles) - 1) // 2 + 1)
    return frequencies[kept], density.mean(axis=1)[kept]


def assert_equal(result: ProfileSpectrum, frequencies: Array, density: Array) -> None:
    assert result.frequencies == pytest.approx(frequencies.tolist())
    assert result.density == pytest.approx(density.tolist(), rel=1e-9, abs=1e-15)
    if len(frequencies) > 1 and density.min() > 1e-9:
        assert result.exponent == pytest.approx(-np.polyfit(np.log(frequencies), np.log(density), 1)[0])


@given(st.integers(0, 2**32 - 1), st.integers(1, 40), st.integers(1, 40))
def test_spectra_are_those_of_scipy_s_periodogram(seed: int, n_x: int, n_y: int) -> None:
    levels = np.random.default_rng(seed).integers(0, 5, (n_x, n_y))
    result = spectrum(bare(levels))
    for side, heights in ((result.west_east, levels * 0.1), (result.south_north, levels.T * 0.1)):
        if len(heights) < 2:  # scipy has no line through one point
            assert side.exponent is None
            continue
        assert_equal(side, *judged(heights, 0.1))


def test_profiles_end_at_frames_and_shorter_ones_are_left_out() -> None:
    levels = np.random.default_rng(3).integers(0, 5, (12, 6)).astype(np.int16)
    whole, frame = framed(levels, 6, "divided")
    apart = np.concatenate([levels[:6], levels[6:]], axis=1)
    field = StepField(levels=whole, frame=frame, block_width=0.1, unit=0.1, frame_height=0.1)
    result = spectrum(field)
    assert_equal(result.west_east, *judged(apart * 0.1, 0.1))
    hole = np.zeros_like(frame)
    hole[2, 1] = True  # that row of x is cut in two pieces shorter than the others
    others = np.delete(whole, 1, axis=1)
    result = spectrum(replace(field, levels=np.where(hole, np.int16(0), whole), frame=hole))
    assert_equal(result.west_east, *judged(others * 0.1, 0.1))


@given(fields())
def test_no_figure_is_nan_or_infinite(found: StepField) -> None:
    assume(not found.frame.all())
    result = spectrum(found)
    for side in (result.west_east, result.south_north):
        assert np.isfinite([*side.frequencies, *side.density, side.exponent or 0.0]).all()


@pytest.mark.parametrize(
    "levels", [np.zeros((30, 30)), np.indices((30, 30))[0], np.ones((1, 30)), np.ones((4, 4))], ids=str
)
def test_level_ground_a_ramp_and_short_rows_have_no_exponent(levels: Array) -> None:
    assert spectrum(bare(levels)).west_east.exponent is None


def test_independent_blocks_have_an_exponent_of_nearly_0_and_walks_of_nearly_2() -> None:
    draws = np.random.default_rng(1).integers(-1, 2, (400, 100))
    assert spectrum(bare(draws + 1)).west_east.exponent == pytest.approx(0, abs=0.05)
    walk = np.cumsum(draws, axis=0)
    result = spectrum(bare(walk - walk.min()))
    assert result.west_east.exponent == pytest.approx(2, abs=0.3)  # less than 2: higher frequencies are folded back
    assert not result.west_east.exponent_is_weak
    assert result.south_north.exponent == pytest.approx(0, abs=0.3)  # its profiles are nearly copies of each other
