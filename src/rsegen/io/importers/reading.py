"""The importer of a file, and its heights as the recipe of one map.

file --Importer.read--> Heights --recipe_of--> Recipe of one matrix, and another one for filled holes
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from rsegen.errors import FileError, ParameterError
from rsegen.io.importers.base import IMPORTERS, Heights, Importer
from rsegen.recipe.recipe import Recipe

if TYPE_CHECKING:
    from rsegen.field.stepfield import Ints


def importer_for(path: Path) -> type[Importer]:
    """Return the importer for a file by its suffix, or a FileError that lists the known ones."""
    importer = IMPORTERS.get(path.suffix.lower())
    if not importer:
        raise FileError(f"{path}: heights are read from files named {', '.join('*' + suffix for suffix in IMPORTERS)}")
    return importer


def imported(path: Path, reading: Importer, unit_cm: float | None = None, chunk_size: int | None = None) -> Recipe:
    """Return the recipe of one map: the heights in a file as a matrix, without frames unless the file names them.

    unit_cm: the height of one level, by default that of the file
    chunk_size: must divide both sides; by default that of the file, or 10 if it divides both sides, else the largest
    number up to 1000 that does
    """
    return recipe_of(path, heights_in(path, reading, unit_cm), chunk_size)


def heights_in(path: Path, reading: Importer, unit_cm: float | None = None) -> Heights:
    """Return the heights in a file, as levels of `unit_cm`, by default that of the file."""
    import numpy as np

    with np.errstate(all="ignore"):  # what is no number, or too large for one, is found in whole_units
        return reading.read(path, unit_cm)


def recipe_of(path: Path, heights: Heights, chunk_size: int | None = None) -> Recipe:
    """Return the recipe of one map of heights, with those of filled holes as a matrix of their own; see `imported`."""
    from rsegen.field.obstacles.matrix import Matrix

    n_x, n_y = heights.levels.shape
    side = _side(n_x, n_y, chunk_size or heights.recipe_values.get("chunk_size"))
    recipe_values = {"boundary": "none", **heights.recipe_values, "unit_cm": heights.unit_cm, "chunk_size": side}
    return Recipe(
        name=re.sub(r"[^A-Za-z0-9_.\-]", "_", path.stem).lstrip(".-")[:64] or "heights",
        description=re.sub(r"[\x00-\x1f]", " ", f"heights of {path.name}")[:500],
        chunks=(n_x // side, n_y // side),
        seed=0,
        obstacles=tuple(Matrix.of(levels, key=key) for key, levels in _parts(heights)),
        **recipe_values,
    )


def _parts(heights: Heights) -> Iterator[tuple[str, Ints]]:
    """Yield the levels that were measured, and those of holes if any were filled; -1 elsewhere."""
    import numpy as np

    holes = heights.holes
    if holes is None or not holes.any():
        yield "heights", heights.levels
    else:
        yield "heights", np.where(holes, -1, heights.levels)
        yield "filled-holes", np.where(holes, heights.levels, -1)


def _side(n_x: int, n_y: int, wished: int | None) -> int:
    """Return the side of a chunk, a divisor of both sides of the map: by default 10, as of a pallet, if it is one."""
    common = math.gcd(n_x, n_y)
    if wished and common % wished:
        raise ParameterError("chunk_size", f"{wished} does not divide {n_x} x {n_y} cells; {common} does")
    return wished or next(side for side in (10, *range(min(common, 1000), 0, -1)) if common % side == 0)
