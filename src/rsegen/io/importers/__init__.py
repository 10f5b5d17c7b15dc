"""Heights from elsewhere: every file of this folder is a format, and is found by being there.

file --Format.read--> Heights --imported--> Recipe of one matrix
"""

from __future__ import annotations

import math
import re
from pathlib import Path

from rsegen.errors import FileError, ParameterError
from rsegen.field.obstacles.matrix import Matrix
from rsegen.io.importers.base import FORMATS, Format, Heights
from rsegen.recipe.recipe import Placement, Recipe


def format_of(path: Path) -> type[Format]:
    """The format of a file by its suffix, or a FileError that lists the known ones."""
    found = FORMATS.get(path.suffix.lower())
    if not found:
        raise FileError(f"{path}: heights are read from files named {', '.join('*' + suffix for suffix in FORMATS)}")
    return found


def imported(path: Path, reading: Format, unit_cm: float | None = None, chunk_size: int | None = None) -> Recipe:
    """The recipe of one map: the heights in a file as a matrix, without frames where the file says of none.

    unit_cm is the step that heights are counted in, by default what the file says, and so is chunk_size. That must
    divide both sides; where nothing is said it is 10 if that does, else the largest number up to 1000 that does.
    """
    heights = reading.read(path, unit_cm)
    matrix = Matrix.of(heights.levels)
    n_x, n_y = matrix.size
    side = _side(n_x, n_y, chunk_size or heights.said.get("chunk_size"))
    said = {"boundary": "none", **heights.said, "unit_cm": heights.unit_cm, "chunk_size": side}
    return Recipe(
        name=re.sub(r"[^A-Za-z0-9_.\-]", "_", path.stem).lstrip(".-")[:64] or "heights",
        description=re.sub(r"[\x00-\x1f]", " ", f"heights of {path.name}")[:500],
        chunks=(n_x // side, n_y // side),
        seed=0,
        obstacles=(Placement(obstacle=matrix, key="heights"),),
        **said,
    )


def _side(n_x: int, n_y: int, wished: int | None) -> int:
    """The side of a chunk, which divides both sides of the map."""
    common = math.gcd(n_x, n_y)
    if wished and common % wished:
        raise ParameterError("chunk_size", f"{wished} does not divide {n_x} x {n_y} cells; {common} does")
    return wished or next(side for side in (10, *range(min(common, 1000), 0, -1)) if common % side == 0)


__all__ = ["FORMATS", "Format", "Heights", "format_of", "imported"]
