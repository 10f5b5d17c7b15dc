"""A field, or a window of it, as a grid of integer labels for height and material, from which all geometry is made."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from rsegen.field.stepfield import Array, CellWindow, Ints, StepField
from rsegen.geometry.mesh import Lattice
from rsegen.params.sorts import NANOMETRE_DIGITS


class LabelGrid(NamedTuple):
    """Labels (n_x + 2, n_y + 2) of a window's cells and a border: rank * materials + material; 0 is the ground.

    A rank is the index of a height among the lattice's z lines; a material is 0 for a frame, else the level.
    """

    labels: Ints
    materials: int
    lattice: Lattice

    @property
    def cells(self) -> Ints:
        """Labels of the window without the border."""
        return self.labels[1:-1, 1:-1]


def label_grid(field: StepField, window: CellWindow | None = None) -> LabelGrid:
    """Return the label grid of a field, or of a window of it; outside the field is ground."""
    cells_x, cells_y = window or field.whole
    seen = slice(max(cells_x.start - 1, 0), cells_x.stop + 1), slice(max(cells_y.start - 1, 0), cells_y.stop + 1)
    labels, materials, tops = _labels(field, seen)
    around = np.zeros([part.stop - part.start + 2 for part in (cells_x, cells_y)], dtype=labels.dtype)
    x, y = (part.start - cells.start + 1 for part, cells in zip(seen, (cells_x, cells_y), strict=True))
    around[x : x + labels.shape[0], y : y + labels.shape[1]] = labels
    edges_x, edges_y = field.edges()
    lines = edges_x[cells_x.start : cells_x.stop + 1], edges_y[cells_y.start : cells_y.stop + 1], tops
    return LabelGrid(around, materials, Lattice(lines=lines))


def split_window(window: CellWindow, side: int) -> Iterator[CellWindow]:
    """Yield the parts of a window, of at most `side` x `side` cells, from the corner of smallest x and y on."""
    for x in range(window[0].start, window[0].stop, side):
        for y in range(window[1].start, window[1].stop, side):
            yield slice(x, min(x + side, window[0].stop)), slice(y, min(y + side, window[1].stop))


def _labels(field: StepField, seen: CellWindow) -> tuple[Ints, int, Array]:
    """Return the label of every cell, the number of materials, and the heights of the ranks."""
    # Only levels that occur have a rank, so that labels stay small on maps of few, high levels.
    levels, frame = field.levels[seen], field.frame[seen]
    known = np.flatnonzero(np.bincount(levels.ravel()))
    heights = np.round(known * field.unit, NANOMETRE_DIGITS)
    frame_height = round(field.frame_height, NANOMETRE_DIGITS) if frame.any() else 0.0
    tops = np.array(sorted({0.0, frame_height, *heights.tolist()}))
    materials = int(known[-1]) + 1
    label_of: Ints = np.zeros(materials, dtype=np.int32 if len(tops) * materials < 2**30 else np.int64)
    label_of[known] = np.searchsorted(tops, heights) * materials + known
    label_of[0] = 0
    labels: Ints = label_of[levels]
    labels[frame] = np.searchsorted(tops, frame_height) * materials
    return labels, materials, tops
