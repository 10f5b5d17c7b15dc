"""The map as a grid_map for elevation mapping: its layers as files, which a node of the package publishes.

    StepField --layers--> elevation.npy, friction.npy, elevation.json --nodes/elevation.py--> grid_map_msgs/GridMap

The arrays have one value per cell, with free ground around the map; the node repeats them, so that steps stay steep
between the points of a grid_map, which RViz joins by slopes.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from rsegen.formats.encoded import as_json
from rsegen.npy_files import npy_bytes
from rsegen.scene.scene import Scene

_MOST_POINTS = 1_000_000
"""Points of a grid_map at the most, if that leaves one per cell: a message of 8 MB with two layers."""

_PER_CELL = 5
"""Points along each side of a cell: 2 cm apart for blocks of 10 cm."""


def layer_files(scene: Scene, margin: int) -> Mapping[str, list[bytes]]:
    """Return the files of a map with `margin` cells of ground around it; heights in metres above the ground."""
    field = scene.field
    levels = np.where(field.frame, -1, field.levels)  # 0 is the ground here, and the frame in `friction_of`
    friction = np.full(field.shape, scene.friction, dtype=np.float32)  # of the ground, level 0
    for level in np.unique(levels[levels != 0]).tolist():
        friction[levels == level] = scene.friction_of(max(level, 0))
    layers = {
        "elevation": np.pad(field.heights.astype(np.float32), margin),
        "friction": np.pad(friction, margin, constant_values=scene.friction),
    }
    points = max(1, min(_PER_CELL, int((_MOST_POINTS / layers["elevation"].size) ** 0.5)))
    about = {
        "axes": "axis 0 along +x, axis 1 along +y; the middle of the arrays is the origin of the frame map",
        "cell_size": field.block_width,
        "points_per_cell": points,
        "layers": list(layers),
    }
    return {
        "elevation.json": [as_json(about)],
        **{f"{name}.npy": [npy_bytes(values)] for name, values in layers.items()},
    }
