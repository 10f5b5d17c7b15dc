"""Levels of what the methods of an obstacle kind give: a profile, an overhang, a layout.

A kind may be a plug-in's, and give anything. Levels have 16 bits, in which larger numbers would become others.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from rsegen.errors import PluginError, shown
from rsegen.field.stepfield import Array, Levels, Mask
from rsegen.params.registry import is_own
from rsegen.params.sorts import MOST_LEVELS

if TYPE_CHECKING:
    from rsegen.obstacles.base import Grid, Layout, Shaped

SLACK = 1e-9
"""Added before a product of floats is rounded down: (n - 1) f of 2.9999999999999996 is level 3, as in exact numbers."""


def levels_of(shape: Shaped, profile: object, cells: tuple[int, ...]) -> Levels:
    """Return the levels floor((n - 1) f) of a profile f; PluginError if it is no array of these cells, from 0 to 1."""
    # A profile that depends on x alone, or that is a number, is spread over the cells.
    where = f"obstacle kind {shape.kind}: profile()"
    try:
        f = np.broadcast_to(np.asarray(profile).astype(float, casting="same_kind", copy=False), cells)
    except (TypeError, ValueError):
        raise PluginError(f"{where} gave {shown(profile)}; expected an array of floats of shape {cells}") from None
    if math.isnan(f.min(initial=0)):  # which is nan if any is
        raise PluginError(f"{where} is not a number (nan) somewhere; use 0 to 1")
    levels = np.floor((shape.levels - 1) * f + SLACK)
    if not is_own(shape):
        _refuse_too_far(levels, where)
    return levels.astype(np.int16)


def margin_of(shape: Shaped, grid: Grid) -> int:
    """Return how many whole cells a shape may extend beyond the rectangle of its ends."""
    overhang = shape.overhang(grid)
    try:
        return math.ceil(overhang)
    except (TypeError, ValueError, OverflowError):  # no number, nan and infinity
        problem = f"overhang() gave {shown(overhang)}; expected a number of cells"
        raise PluginError(f"obstacle kind {shape.kind}: {problem}") from None


def refuse_other_layout(layout: Layout, levels: Array | Levels, covered: Mask, shape: tuple[int, int]) -> None:
    """Raise a PluginError if a plug-in's layout does not have the shape of its rectangle, or levels that no map has."""
    if is_own(layout):
        return
    where = f"obstacle kind {layout.kind}: laid_out()"
    if np.shape(levels)[-2:] != shape or np.shape(covered) != shape:
        raise PluginError(f"{where} must return two arrays of shape {shape}")
    _refuse_too_far(levels, where)


def _refuse_too_far(levels: Array | Levels, where: str) -> None:
    far = np.abs(levels)
    if far.size and not far.max() <= MOST_LEVELS:
        problem = f"makes levels of up to {far.max():g}"
        raise PluginError(f"{where} {problem}; a map has up to {MOST_LEVELS}, and a profile is 0 to 1")
