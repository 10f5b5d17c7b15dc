"""The cells under a robot, for every heading and every place of its origin within a cell."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from math import inf, pi

import numpy as np

from rsegen.field.spots.footprint import TOUCHING, Footprint, Rectangle
from rsegen.field.spots.overlap import overlapped
from rsegen.field.stepfield import Array, Mask

HEADINGS = 16
"""Headings that are tried at every place, evenly spread."""

MARGIN = 0.004
"""Metres around every part of a robot in which the ground has to be as even and as free as under it."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Stencil:
    """The cells under a robot at one heading and one place `at` within its cell, as masks of (2 cells + 1)^2 cells.

    at: x and y as shares of the width of a cell; bottoms: the height of the lowest part above each cell, inf if there
    is none; outline: the rectangle around the robot; ways: the next such rectangle ahead, and behind
    """

    yaw: float
    at: tuple[float, float]
    bottoms: Array
    outline: Mask
    ways: tuple[Mask, Mask]

    @property
    def parts(self) -> Mask:
        """The cells under any part."""
        return np.isfinite(self.bottoms)

    @property
    def supports(self) -> Mask:
        """The cells under the supports."""
        return self.bottoms <= TOUCHING


def stencils(footprint: Footprint, cells: int, width: float) -> Sequence[Stencil]:
    """Those of a footprint for all headings, at the centre, an edge and a corner of a cell of this width in metres."""
    yaws = [number * 2 * pi / HEADINGS for number in range(HEADINGS)]
    return [_stencil(footprint, yaw, (x, y), cells, width) for yaw, x, y in product(yaws, (0.0, 0.5), (0.0, 0.5))]


def _stencil(footprint: Footprint, yaw: float, at: tuple[float, float], cells: int, width: float) -> Stencil:
    def under(rectangle: Rectangle) -> Mask:
        return overlapped(rectangle, yaw, (at[0] * width, at[1] * width), cells, width)

    bottoms = np.full((2 * cells + 1,) * 2, inf)
    for rectangle, bottom in footprint.undersides:
        np.minimum(bottoms, bottom, out=bottoms, where=under(rectangle.grown(MARGIN)))
    outline, length = footprint.outline, footprint.outline.length
    ahead, behind = (under(outline.ahead(sign * length)) for sign in (1, -1))
    return Stencil(yaw=yaw, at=at, bottoms=bottoms, outline=under(outline) | np.isfinite(bottoms), ways=(ahead, behind))
