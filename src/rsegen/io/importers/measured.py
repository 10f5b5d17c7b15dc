"""What importers of measured heights share: unit, ground, resampling, holes and rounding."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, radians, sin
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from rsegen.errors import FileError, ParameterError
from rsegen.field.stepfield import Array
from rsegen.io.importers.base import Heights, Importer, refuse_too_many_cells, whole_units
from rsegen.io.importers.rounding import filled
from rsegen.io.importers.sampling import sampled
from rsegen.params.places import Cell, Size2D
from rsegen.params.sorts import Flag, Float, ListOf

RESAMPLED = "resample to this many cells along x and y; default: one per cell, or pixel, of the file"

_MOST_HOLES = 0.5


@dataclass(frozen=True, kw_only=True, slots=True)
class Measured(Importer):
    """An importer of heights that were measured."""

    rounded: Annotated[bool, Flag(help="round heights that are not whole units; without it they are errors")] = False
    any_heights: Annotated[
        bool, Flag(help="round heights even if most are far from whole units, as those of natural ground are")
    ] = False
    datum_cm: Annotated[
        float | None, Float(-100_000, 100_000, unit="cm", help="height of the ground in the file, which is subtracted")
    ] = None
    fill_holes: Annotated[
        bool, Flag(help="give blank cells and holes the median height of their neighbours; the recipe lists them apart")
    ] = False
    size: Annotated[Cell | None, Size2D(help=RESAMPLED)] = None
    cells_per_block: Annotated[
        float | None, Float(0.01, 4096, help="cells of the file along the side of a block, for size")
    ] = None
    origin: Annotated[
        tuple[float, float] | None,
        ListOf(
            Float(-4096, 4096),
            2,
            help="south-west corner of the map in the file, in cells from its own, for size; default: centred",
        ),
    ] = None
    rotation: Annotated[
        float, Float(-360, 360, unit="degrees", help="angle of the map in the file, counterclockwise")
    ] = 0.0

    def measured(
        self, path: Path, found: Array, unit_cm: float, recipe_values: dict[str, Any] | None = None
    ) -> Heights:
        """Heights [cm] of a file, shape (n_x, n_y), nan for holes, as those of a map; a FileError if they are none."""
        heights = self._resampled(found) - (self.datum_cm or 0)
        holes = np.isnan(heights)
        if self.fill_holes and holes.any():
            if holes.mean() > _MOST_HOLES:
                raise FileError(
                    f"{path}: {int(holes.sum()):,} of {holes.size:,} cells are holes; at most half are filled"
                )
            heights = filled(heights, holes)
        rounded = self.rounded or self.any_heights
        levels = whole_units(path, heights, unit_cm, rounded=rounded, any_heights=self.any_heights, holes=holes)
        return Heights(
            levels=levels,
            unit_cm=unit_cm,
            recipe_values=recipe_values or {},
            errors_cm=heights - levels * unit_cm,
            holes=holes,
        )

    def _resampled(self, heights: Array) -> Array:
        """The heights of the blocks of a map; those of the file if nothing else is asked for."""
        quarters, rest = divmod(self.rotation, 90)
        if self.size is None:
            if rest or self.origin or self.cells_per_block:
                raise ParameterError(
                    "size", "give the number of blocks along x and y with origin, rotation, cells_per_block"
                )
            return np.rot90(heights, -int(quarters))
        extent = heights.shape[:: -1 if quarters % 2 else 1]
        whole = self.cells_per_block is None and self.origin is None and not rest
        cells = self.cells_per_block or 1.0
        per_block = (extent[0] / self.size[0], extent[1] / self.size[1]) if whole else (cells, cells)
        refuse_too_many_cells(Path("size"), *self.size)
        return sampled(heights, self.size, per_block, self.origin or self._centred(heights, per_block), self.rotation)

    def _centred(self, heights: Array, per_block: tuple[float, float]) -> tuple[float, float]:
        """The south-west corner of a map whose middle is that of the file."""
        u, v = (blocks * cells / 2 for blocks, cells in zip(self.size or (), per_block, strict=True))
        c, s = cos(radians(self.rotation)), sin(radians(self.rotation))
        n_x, n_y = heights.shape
        return n_x / 2 - (u * c - v * s), n_y / 2 - (u * s + v * c)
