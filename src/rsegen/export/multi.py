"""Mesh type `multi`: every block and every frame cell is a static box of its own, to be moved, deleted or copied."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from rsegen.export import sdf
from rsegen.export.numbers import decimal
from rsegen.scene import Scene


def files(scene: Scene) -> dict[str, Iterable[bytes]]:
    """One world file, made as it is written."""
    return {f"{scene.name}.world": sdf.encoded(sdf.world(scene, boxes(scene)))}


def models(scene: Scene) -> int:
    """Cells above the ground."""
    return int((scene.field.heights > 0).sum())


def faces(scene: Scene) -> int:
    """Six a box."""
    return 6 * models(scene)


def boxes(scene: Scene) -> Iterator[str]:
    """A model for each cell above the ground: `block_X_Y` by block cell, `frame_I_J` by cell with frames counted."""
    field = scene.field
    x, y = ([decimal(float(at)) for at in (line[:-1] + line[1:]) / 2] for line in field.edges())
    block_x, block_y = (np.cumsum(field.inside(axis)) - 1 for axis in (0, 1))
    heights = field.heights
    for i, j in zip(*(cells.tolist() for cells in np.nonzero(heights)), strict=True):
        name = f"frame_{i}_{j}" if field.frame[i, j] else f"block_{block_x[i]}_{block_y[j]}"
        material = 0 if field.frame[i, j] else int(field.levels[i, j])
        yield sdf.box_model(name, (x[i], y[j]), (field.block_width, float(heights[i, j])), scene, material)
