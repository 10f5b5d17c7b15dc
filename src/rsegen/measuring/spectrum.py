"""Power spectral density of the heights along x and along y, and the exponent with which it falls.

Idea: ground is rough at some lengths and smooth at others. Each profile, a row of blocks without a frame between them,
loses its line of least squares and is tapered by a Hann window; the periodogram says how much of its variance is in
each frequency f, and S ~ f^-b is fitted to the mean of all profiles: b is near 0 if blocks are independent, and larger
if neighbours are alike. Vehicle dynamics describes roads so (Andrén, International Journal of Vehicle Design 2006, is a
survey of the fits), and Hoffman and Krotkov (1989) detrend and window the heights of terrain.

Cost: n log n of the cells. What breaks it: short profiles, as the line takes most of the lowest frequency, and 10
blocks leave four frequencies; and a block is one sample, so nothing is said of lengths below two blocks, where the
vertical sides are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rsegen.field.stepfield import Array, StepField
from rsegen.measuring.roughness import FEW, exponent

_ROUNDING = 1e-12
"""Share of the largest density below which a density is rounding: squares of numbers that are exact to 1e-16, with
room for sums over long profiles. Its logarithm says nothing."""


@dataclass(frozen=True, kw_only=True, slots=True)
class ProfileSpectrum:
    """The one-sided power spectral density S of the profiles along one axis.

    frequencies: cycles per metre, without 0 and the highest one, which is half as wide; density: m^2 per cycle/m
    exponent: b of S ~ f^-b, by least squares on the logarithms; None for fewer than two frequencies with power
    """

    frequencies: tuple[float, ...]
    density: tuple[float, ...]
    exponent: float | None
    exponent_is_weak: bool


@dataclass(frozen=True, kw_only=True, slots=True)
class Spectrum:
    """The spectra from west to east and from south to north, which differ if obstacles have a direction."""

    west_east: ProfileSpectrum
    south_north: ProfileSpectrum


def spectrum(field: StepField) -> Spectrum:
    """Return the spectra of a field's blocks."""
    west_east, south_north = (_spectrum(field, axis) for axis in (0, 1))
    return Spectrum(west_east=west_east, south_north=south_north)


def _spectrum(field: StepField, axis: int) -> ProfileSpectrum:
    profiles = _profiles(field, axis)
    n = profiles.shape[1]
    # Without their lines of least squares, and tapered.
    along = np.arange(n) - (n - 1) / 2
    slopes = profiles @ along / max(float(along @ along), 1.0)
    profiles = profiles - profiles.mean(axis=1, keepdims=True) - slopes[:, None] * along
    window = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(n) / n)
    power = np.abs(np.fft.rfft(profiles * window, axis=1)) ** 2
    inner = slice(1, (n - 1) // 2 + 1)  # without 0, and without the highest frequency of an even n
    # Twice, as negative frequencies have the same power as positive ones.
    scale = 2 * field.unit**2 * field.block_width / max(float(window @ window), 1.0)
    density = power.mean(axis=0)[inner] * scale
    frequencies = np.fft.rfftfreq(n, field.block_width)[inner]
    has_power = density > _ROUNDING * max(float(power.mean(axis=0).max()) * scale, field.unit**2 * field.block_width)
    slope = exponent(frequencies[has_power], density[has_power])
    return ProfileSpectrum(
        frequencies=tuple(frequencies.tolist()),
        density=tuple(density.tolist()),
        exponent=None if slope is None else -slope,
        exponent_is_weak=int(has_power.sum()) < FEW,
    )


def _profiles(field: StepField, axis: int) -> Array:
    """Return the levels of the longest rows of blocks along an axis, between frames or sides, (profiles, n)."""
    levels, block = (field.levels, ~field.frame) if axis == 0 else (field.levels.T, ~field.frame.T)
    # Shorter rows, if any, have other frequencies: their spectra cannot be averaged with these. In `ends` a row begins
    # at 1 and stops at -1.
    ends = np.diff(np.pad(block.T, ((0, 0), (1, 1))).astype(np.int8), axis=1)
    line, first = np.nonzero(ends == 1)
    length = np.nonzero(ends == -1)[1] - first
    longest = length == length.max()
    along = first[longest, None] + np.arange(length.max())
    return levels[along, line[longest, None]].astype(np.float64)
