"""The common base of importers of measured heights: unit, ground, resampling, holes and rounding.

A table that is finer than blocks, shifted or turned is sampled: each block gets the median of up to 15 x 15 points on
it, which ignores edges and outliers, and is a hole if more than half of the points are. Then the ground is subtracted,
holes are filled on request, and heights are rounded to levels. Cost: at most 2^26 samples, a second. What breaks it: a
grid that is turned or scaled by more than about a block over the map, so that points lie on neighbouring blocks.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, cos, isqrt, radians, sin
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from rsegen.errors import FileError, ParameterError
from rsegen.heights.base import (
    MOST_CM,
    Heights,
    Importer,
    filled,
    lower_medians,
    refuse_too_many_cells,
    whole_units,
)
from rsegen.params.sorts import Flag, Float, ListOf, Size2D, parameters
from rsegen.recipe.recipe import Recipe

if TYPE_CHECKING:
    from rsegen.field.stepfield import Array
    from rsegen.heights.coordinate_system import CellSides


_MOST_ALONG = 15
"""Samples along a side of a block at most: the median of 225 points is surer than a block is level."""

_MOST_SAMPLES = 2**26
"""Samples of a map at most: blocks of larger maps get fewer; more would take seconds."""


def sampled(
    heights: Array, size: Sequence[int], per_block: Sequence[float], origin: Sequence[float], turn: float
) -> Array:
    """Return the median height over each block, shape `size`; nan where more than half of a block is nan or outside.

    heights: (n_x, n_y) of a file's cells, nan for holes; per_block: its cells along a block's sides; origin: the
    map's south-west corner, in cells from the file's; turn: of the map in the file, degrees counterclockwise.
    """
    import numpy as np

    # Points lie evenly on each block, about one per cell of the file; (u, v) of the map are turned into the file.
    most = max(min(_MOST_ALONG, isqrt(_MOST_SAMPLES // (size[0] * size[1]))), 1)
    samples = [min(max(ceil(cells), 1), most) for cells in per_block]
    along = [
        (np.arange(blocks * n).reshape(blocks, n) + 0.5) / n * cells
        for blocks, n, cells in zip(size, samples, per_block, strict=True)
    ]
    c, s = cos(radians(turn)), sin(radians(turn))
    rows = (_heights_at(heights, origin, u[:, None, None], along[1], (c, s)) for u in along[0])
    points = (row.transpose(1, 0, 2).reshape(size[1], -1) for row in rows)
    return np.array([np.where(np.isnan(row).mean(axis=1) > 0.5, np.nan, lower_medians(row)) for row in points])


def _heights_at(heights: Array, origin: Sequence[float], u: Array, v: Array, turned: tuple[float, float]) -> Array:
    """Return the heights of the file at points u, v of the map."""
    import numpy as np

    c, s = turned
    x, y = (
        np.floor(np.round(along, 6)).astype(np.int64)  # a point on an edge stays on its side
        for along in (origin[0] + u * c - v * s, origin[1] + u * s + v * c)
    )
    n_x, n_y = heights.shape
    inside = (x >= 0) & (x < n_x) & (y >= 0) & (y < n_y)
    return np.where(inside, heights[x.clip(0, n_x - 1), y.clip(0, n_y - 1)], np.nan)


def _block_width(sides: CellSides | None) -> dict[str, float]:
    """Return the width of blocks as a recipe has it; nothing if it is not known, or no width of blocks."""
    if sides is None or sides.metres is None or not sides.is_square:
        return {}
    width = round(sides.x * sides.metres * 100, 6)
    try:
        return {"block_width_cm": parameters(Recipe)["block_width_cm"].check("block_width_cm", width)}
    except ParameterError:
        return {}


RESAMPLED = "resample to this many cells along x and y; default: one per cell, or pixel, of the file"

_MOST_HOLES = 0.5
"""Share of cells that may be filled: with more holes the map would be made up rather than measured."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Measured(Importer):
    """An importer of heights that were measured."""

    rounded: Annotated[bool, Flag(help="round heights that are not whole units; else they are an error")] = False
    any_heights: Annotated[
        bool, Flag(help="round heights even if most are far from whole units, as those of natural ground are")
    ] = False
    datum_cm: Annotated[
        float | None, Float(-MOST_CM, MOST_CM, unit="cm", help="height of the ground in the file, which is subtracted")
    ] = None
    fill_holes: Annotated[
        bool,
        Flag(help="fill blank cells and holes with the median height of their neighbours; the recipe lists them apart"),
    ] = False
    size: Annotated[Sequence[int] | None, Size2D(help=RESAMPLED)] = None
    cells_per_block: Annotated[
        float | None, Float(0.01, 4096, help="with size: cells of the file along one side of a block")
    ] = None
    origin: Annotated[
        Sequence[float] | None,
        ListOf(
            Float(-4096, 4096),
            2,
            help="with size: south-west corner of the map, in cells from that of the file; default: centred",
        ),
    ] = None
    rotation: Annotated[
        float, Float(-360, 360, unit="degrees", help="angle of the map in the file, counterclockwise")
    ] = 0.0

    def measured(
        self,
        path: Path,
        heights_cm: Array,
        unit_cm: float,
        recipe_values: dict[str, Any] | None = None,
        cells: CellSides | None = None,
    ) -> Heights:
        """Return heights [cm] of a file, shape (n_x, n_y), nan for holes, as levels; a FileError if they are none.

        cells: the sides of its cells, if it says them; blocks are as wide then.
        """
        import numpy as np

        # In this order: blocks of the map, then their ground, then holes, then levels.
        heights = self._resampled(heights_cm) - (self.datum_cm or 0)
        holes = np.isnan(heights)
        if self.fill_holes and holes.any():
            if holes.mean() > _MOST_HOLES:
                raise FileError(
                    f"{path}: {int(holes.sum()):,} of {holes.size:,} cells are holes; at most half are filled"
                )
            heights = filled(heights, holes)
        rounded = self.rounded or self.any_heights
        levels = whole_units(path, heights, unit_cm, rounded=rounded, any_heights=self.any_heights, holes=holes)
        sides = cells and self._of_blocks(cells, heights_cm.shape)
        return Heights(
            levels=levels,
            unit_cm=unit_cm,
            recipe_values={**(recipe_values or {}), **_block_width(sides)},
            errors_cm=heights - levels * unit_cm,
            holes=holes,
            sides=sides,
        )

    def _of_blocks(self, cells: CellSides, shape: tuple[int, ...]) -> CellSides:
        """Return the sides of the blocks of a map, from the sides of the cells of its file."""
        if int(self.rotation // 90) % 2:  # a quarter turn swaps x and y
            cells = cells._replace(x=cells.y, y=cells.x)
        return cells.of_blocks(*self._per_block(shape)) if self.size else cells

    def _resampled(self, heights: Array) -> Array:
        """Return the heights of the blocks of a map; without `size` a cell of the file is a block."""
        import numpy as np

        quarters, remainder = divmod(self.rotation, 90)
        if self.size is None:
            if remainder or self.origin or self.cells_per_block:
                raise ParameterError(
                    "size", "missing; origin, rotation and cells_per_block need the number of blocks along x and y"
                )
            return np.rot90(heights, -int(quarters))
        per_block = self._per_block(heights.shape)
        refuse_too_many_cells(Path("size"), *self.size)
        return sampled(heights, self.size, per_block, self.origin or self._centred(heights, per_block), self.rotation)

    def _per_block(self, shape: tuple[int, ...]) -> tuple[float, float]:
        """Return how many cells of a file of a shape a block has along x and y of a map of `size`."""
        quarters, remainder = divmod(self.rotation, 90)
        if self.cells_per_block is not None or self.origin is not None or remainder:
            return (self.cells_per_block or 1.0,) * 2
        # Nothing but a size: the map has all of the file.
        n_x, n_y = shape[:: -1 if quarters % 2 else 1]
        size_x, size_y = self.size or (n_x, n_y)
        return n_x / size_x, n_y / size_y

    def _centred(self, heights: Array, per_block: tuple[float, float]) -> tuple[float, float]:
        """Return the south-west corner, in cells of the file, of a map that is centred on it."""
        u, v = (blocks * cells / 2 for blocks, cells in zip(self.size or (), per_block, strict=True))
        c, s = cos(radians(self.rotation)), sin(radians(self.rotation))
        n_x, n_y = heights.shape
        return n_x / 2 - (u * c - v * s), n_y / 2 - (u * s + v * c)
