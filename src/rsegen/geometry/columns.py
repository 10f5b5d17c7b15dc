"""Boxes on the ground, each of one material: a map's visual and collision geometry where boxes are wanted."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from rsegen.field.stepfield import StepField
from rsegen.geometry.mesh import label_grid
from rsegen.geometry.rectangles import merge


class Column(NamedTuple):
    """A box on the ground: its centre and its size along x, y and z, metres, and its material."""

    centre: tuple[float, float, float]
    size: tuple[float, float, float]
    material: int


def columns(field: StepField) -> Iterator[Column]:
    """Yield few boxes that together fill the blocks and frames of a field and do not overlap."""
    grid = label_grid(field)
    rectangles = merge(grid.cells)
    rank, material = np.divmod(rectangles.label, grid.materials)
    x, y, z = grid.lattice.lines
    low = np.stack([x[rectangles.u0], y[rectangles.v0], np.zeros(len(rank))], axis=1)
    high = np.stack([x[rectangles.u1], y[rectangles.v1], z[rank]], axis=1)
    rows = zip(((low + high) / 2).tolist(), (high - low).tolist(), material.tolist(), strict=True)
    return (Column(tuple(centre), tuple(size), kind) for centre, size, kind in rows)
