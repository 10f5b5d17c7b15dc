"""How light each point of a map is in the 3D view: shadows of the sun, and less light at the foot of higher blocks.

Both are computed from the heights alone, once per map, so that every display shows them, and turning costs nothing.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rsegen.field.stepfield import Array, StepField

Floats = NDArray[np.float32]

SUN = (0.8, 0.45, 1.0)
"""The direction from the map to the sun."""

_TEXELS = 500_000
FINEST = 10
"""Texels along a cell, which suffice for shadows."""

_SHADOW, _CORNER = 0.36, 0.42
_STEPS = 40
_PENUMBRA = 0.35
"""The width of the rim of a shadow, as a share of its distance from what casts it."""


class Shading(NamedTuple):
    """light: (n, m) 0..1, for points on the ground and on tops, x along the first axis; low, high: its corners [m];
    fine: texels along a cell; rim: cells of ground around the field.
    """

    light: Floats
    low: tuple[float, float]
    high: tuple[float, float]
    fine: int
    rim: int


def shading(field: StepField, border: float, finest: int = FINEST) -> Shading:
    """The light on a field and on the ground around it, up to `border` metres away.

    finest: texels along a cell, at most; fewer on maps of many cells
    """
    fine = int(np.clip(np.sqrt(_TEXELS / field.levels.size), 1, finest))
    rim = int(np.ceil(border / field.block_width))
    heights = np.pad(field.heights.astype(np.float32) / np.float32(field.block_width), rim)
    fine_heights = heights.repeat(fine, axis=0).repeat(fine, axis=1) * np.float32(fine)
    light = (1 - _SHADOW * _in_shadow(fine_heights)) * (1 - _CORNER * _in_corners(fine_heights, fine))
    half_x, half_y = (side / 2 + rim * field.block_width for side in field.extent)
    return Shading(light.astype(np.float32), (-half_x, -half_y), (half_x, half_y), fine, rim)


def foot(height: Array) -> Array:
    """The light on a wall at some heights above its foot, in widths of a block: 1 from a width and a half upward."""
    return 1 - _CORNER * 0.8 * np.clip(1 - height / 1.5, 0, 1) ** 2


def _in_shadow(heights: Floats) -> Floats:
    """How much of the sun other blocks hide, 0..1; heights in texels, as are the steps towards the sun."""
    x, y, z = np.array(SUN) / np.hypot(*SUN[:2])
    far = min(float(heights.max() - heights.min()) / z, float(max(heights.shape)))
    hidden = np.zeros_like(heights)
    for distance in np.linspace(0, far, min(int(far), _STEPS) + 1)[1:].tolist():
        di, dj = round(distance * x), round(distance * y)
        if di < heights.shape[0] and dj < heights.shape[1]:
            here = (slice(0, heights.shape[0] - di), slice(0, heights.shape[1] - dj))
            above = heights[di:, dj:] - heights[here] - np.float32(distance * z)
            np.maximum(hidden[here], above / np.float32(_PENUMBRA * distance + 1), out=hidden[here])
    return np.minimum(hidden, 1)


def _in_corners(heights: Floats, fine: int) -> Floats:
    """How much of the sky is hidden, 0..1: by how much the mean height around is above a point."""
    hidden: Floats = np.zeros_like(heights)
    for radius in (max(fine // 3, 1), fine):
        hidden += np.clip((_mean_around(heights, radius) - heights) / np.float32(radius), 0, 1)
    return hidden / np.float32(2)


def _mean_around(heights: Floats, radius: int) -> Floats:
    """The mean over a square of 2 radius + 1 texels a side, beyond the rim of the ground 0."""
    size = 2 * radius + 1
    for _ in (0, 1):
        sums = np.pad(heights, ((radius + 1, radius), (0, 0))).cumsum(axis=0, dtype=np.float32)
        heights = ((sums[size:] - sums[:-size]) / np.float32(size)).T
    return heights
