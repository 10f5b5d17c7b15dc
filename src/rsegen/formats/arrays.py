"""Levels, heights and frames as arrays for numpy, MATLAB and tables."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from rsegen.formats.base import Format, Step, register
from rsegen.formats.encoded import as_json, mat, metadata
from rsegen.npy_files import npy_bytes
from rsegen.recipe.codec import encode
from rsegen.scene.scene import Scene, csv

_FILES = {
    "levels.npy": "int16 (n_x, n_y), level of each block in units, 0 in frame cells",
    "heights.npy": "float64 (n_x, n_y), height of each cell above the ground, metres, frames too",
    "frame.npy": "bool (n_x, n_y), where a frame stands",
    "levels.csv": "levels of the blocks alone, frames left out, north up: the top row is the largest y",
    "levels.mat": "levels, heights, frame as above, unit, block_width and frame_height in metres, seed and name",
}


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Arrays(Format):
    """Levels, heights and frame mask as arrays for numpy (NPY) and MATLAB (MAT), levels as CSV, metadata as JSON."""

    name: ClassVar[str] = "arrays"
    also: ClassVar[tuple[str, ...]] = ("numpy", "npy", "npz", "mat", "matlab", "csv")
    mat_file: ClassVar[str] = "levels.mat"
    step: ClassVar[Step] = "build"

    def files(self, scene: Scene) -> Mapping[str, Iterable[bytes]]:
        """Return the arrays, of shape (n_x, n_y) with frames, the table and the metadata."""
        # The metadata explain only files that are written; without scipy there is no MAT file.
        field = scene.field
        variables = {
            "levels": field.levels,
            "heights": field.heights,
            "frame": field.frame,
            "unit": field.unit,
            "block_width": field.block_width,
            "frame_height": field.frame_height,
            "seed": np.int64(scene.recipe.seed),
            "name": scene.name,
        }
        matlab = {} if self.left_out else {"levels.mat": [mat(variables)]}
        meaning = {name: text for name, text in _FILES.items() if matlab or name != self.mat_file}
        return {
            "levels.npy": [npy_bytes(field.levels)],
            "heights.npy": [npy_bytes(field.heights)],
            "frame.npy": [npy_bytes(field.frame)],
            "levels.csv": csv(field),
            **matlab,
            "meta.json": [as_json({**metadata(scene), "files": meaning, "recipe": encode(scene.alone)})],
        }
