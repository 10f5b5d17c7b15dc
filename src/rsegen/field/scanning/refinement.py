"""Moves a grid until every cell has as few different heights as it can: what a block's top is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from rsegen.errors import ScanError
from rsegen.field.scanning.grid import Grid
from rsegen.field.scanning.ground import sample
from rsegen.field.stepfield import Array, Ints

_MOST_POINTS = 60_000
_NEAR_LEVEL = 0.3
"""Of a unit: points farther from any level are of sides, and tell nothing here."""

_HIGHEST = 30
_HALVINGS = 7
_MOST_LEFT = 0.6
"""Of the points that are not at their cell's level in a grid half a block away, so many may be left at most."""


def refined(grid: Grid, points: Array, unit: float) -> Grid:
    """The grid whose cells are of one level each as nearly as can be, near the one that is given.

    points: (n, 3), x, y and height above the ground [m]; unit: height of a unit [m]. The sum of the points at each
    cell's most frequent level is raised, by steps that are halved. A ScanError if the cells of a grid half a block
    away are nearly as much of one level each: then the edges of the cloud are not those of blocks.
    """
    levels, places = _tops(points, unit)
    if len(levels) < 100:
        raise ScanError("hardly a point is on top of a block; give a scan from above, or another unit_cm")
    middle = np.rint((np.median(places[levels > 0], axis=0) @ grid.rotation.T - grid.origin) / grid.width)
    pivot = (grid.origin + middle * grid.width) @ grid.rotation

    def alike(change: Array) -> int:
        return _one_level(places, levels, _moved(grid, pivot, change))

    best = _climbed(alike)
    away = np.array([*best[:2], *(best[2:] + 0.5)])
    if len(levels) - alike(best) > _MOST_LEFT * (len(levels) - alike(away)):
        raise ScanError(
            "no grid of blocks fits the cloud; give block_width_cm and unit_cm, a closer scan, "
            "or cut everything but the field and some floor out of it"
        )
    return _moved(grid, pivot, best)


def _climbed(alike: Callable[[Array], int]) -> Array:
    """The change of a grid for which most points are alike: of heading, width, and place along x and y."""
    steps = np.array([0.01, 0.01, 0.08, 0.08])  # of a radian, of the width, of a width along x and y
    best, most = np.zeros(4), alike(np.zeros(4))
    for _ in range(_HALVINGS):
        for change in np.concatenate([np.diag(steps), -np.diag(steps)] * 3):
            found = alike(best + change)
            if found > most:
                best, most = best + change, found
        steps = steps / 2
    return best


def _tops(points: Array, unit: float) -> tuple[Ints, Array]:
    """The level and the place (x, y) of points near a level, in the part of the cloud that is above the ground."""
    raised = points[(points[:, 2] > unit / 2) & (points[:, 2] < (_HIGHEST + 0.5) * unit)]
    low, high = np.quantile(raised[:, :2], 0.02, axis=0), np.quantile(raised[:, :2], 0.98, axis=0)
    reach = 0.15 * (high - low)
    inside = ((points[:, :2] > low - reach) & (points[:, :2] < high + reach)).all(axis=1)
    few = sample(points[inside], _MOST_POINTS)
    levels = np.rint(few[:, 2] / unit)
    near = (np.abs(few[:, 2] - levels * unit) < _NEAR_LEVEL * unit) & (levels >= 0) & (levels <= _HIGHEST)
    return levels[near].astype(np.int64), few[near, :2]


def _moved(grid: Grid, pivot: Array, change: Array) -> Grid:
    """A grid turned and stretched about a point (x, y) of the cloud, and moved."""
    turned = replace(grid, heading=grid.heading + change[0], width=grid.width * (1 + change[1]))
    return replace(turned, origin=turned.rotation @ pivot + change[2:] * grid.width)


def _one_level(places: Array, levels: Ints, grid: Grid) -> int:
    """The number of points at the most frequent level of their cell."""
    cells = np.floor((places @ grid.rotation.T - grid.origin) / grid.width).astype(np.int64)
    cells -= cells.min(axis=0)
    keys = (cells[:, 0] * (int(cells[:, 1].max()) + 1) + cells[:, 1]) * (_HIGHEST + 1) + levels
    counts = np.bincount(keys)
    counts = np.append(counts, np.zeros(-len(counts) % (_HIGHEST + 1), dtype=counts.dtype))
    return int(counts.reshape(-1, _HIGHEST + 1).max(axis=1).sum())
