"""Tags of cells: the obstacles of the recipe, and the peaks and pits of the field.

A plateau is a connected area of blocks of one height; frames and the ground around the map are no plateaus, but can be
neighbours of one. Neighbours share a side.

    peak   a plateau that is higher than each of its neighbours by more than a limit
    pit    a plateau that is lower than each of its neighbours by more than a limit
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from rsegen.exporters.scene import Scene
from rsegen.field.metrics.regions import connected, neighbours
from rsegen.field.obstacles.base import Shaped
from rsegen.field.stepfield import NANOMETRE_DIGITS, Ints, Mask, StepField
from rsegen.params.places import Cell
from rsegen.params.sorts import Json
from rsegen.recipe.building import placed

_BLOCK, _FRAME, _GROUND = range(3)


class ObstacleCells(NamedTuple):
    """A barrier or peak of the recipe: its number in the list, its kind, key and ends, and its cells (n_x, n_y).

    The ends count block cells without frames, as a recipe does. The cells are those in which its own level is 1 or
    more, whatever later obstacles do there.
    """

    number: int
    kind: str
    key: str
    first: Cell
    last: Cell
    cells: Mask

    def entry(self) -> dict[str, Json]:
        """The obstacle as a dict for JSON, with the number of its cells."""
        named = {"number": self.number, "kind": self.kind, "key": self.key}
        return {**named, "first": list(self.first), "last": list(self.last), "cells": int(self.cells.sum())}


def obstacle_cells(scene: Scene) -> Iterator[ObstacleCells]:
    """The cells of every barrier and peak of the recipe; a matrix and random kinds have none."""
    field, recipe = scene.field, scene.recipe
    inside = np.ix_(field.inside(0), field.inside(1))
    for number, placement in enumerate(recipe.obstacles):
        if isinstance(placement.obstacle, Shaped):
            first, last, patch = placed(recipe, placement, scene.index)
            blocks = np.zeros(recipe.grid.shape, dtype=bool)
            blocks[patch.window] = patch.footprint
            cells = np.zeros(field.shape, dtype=bool)
            cells[inside] = blocks
            yield ObstacleCells(number, placement.obstacle.kind, placement.key or "", first, last, cells)


def peaks_and_pits(field: StepField, limit: float) -> tuple[Ints, Ints]:
    """For each cell the number of its peak, and of its pit, (n_x, n_y) each; -1 for none; limit: metres."""
    tops = np.pad(np.rint(field.heights * 10**NANOMETRE_DIGITS).astype(np.int64), 1)
    sort = np.pad(np.where(field.frame, _FRAME, _BLOCK), 1, constant_values=_GROUND)
    a, b = neighbours(tops.shape)
    height, kind = tops.ravel(), sort.ravel()
    alike = (height[a] == height[b]) & (kind[a] == kind[b])
    plateau = connected(height.size, a[alike], b[alike])
    a, b = plateau[a[~alike]], plateau[b[~alike]]
    rise = round(limit * 10**NANOMETRE_DIGITS)
    peaks, pits = (
        _numbered(plateau, _beyond(sign * height, a, b, rise)[plateau] & (kind == _BLOCK)).reshape(tops.shape)
        for sign in (1, -1)
    )
    return peaks[1:-1, 1:-1], pits[1:-1, 1:-1]


def _beyond(height: Ints, a: Ints, b: Ints, rise: int) -> Mask:
    """Which plateaus are higher than each adjacent plateau by more than `rise`."""
    least = np.full(height.size, np.iinfo(np.int64).max)
    np.minimum.at(least, a, height[a] - height[b])
    np.minimum.at(least, b, height[b] - height[a])
    return np.asarray(least > rise)


def _numbered(plateau: Ints, chosen: Mask) -> Ints:
    """The plateau number of chosen cells, counted from 0 in the order of first cells; -1 for all others."""
    found = np.full(plateau.size, -1)
    found[chosen] = np.unique(plateau[chosen], return_inverse=True)[1].ravel()
    return found
