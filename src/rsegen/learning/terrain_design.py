"""The arrangement of a terrain: how many tiles, how hard, how far apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated

from rsegen.params.sorts import Float, Integer, ListOf, parameters
from rsegen.recipe.recipe import Run


@dataclass(frozen=True, kw_only=True)
class TerrainDesign:
    """Rows and columns of tiles, the difficulty of the first and last row, and the flat ground around them."""

    rows: Annotated[int, Integer(1, 1000, usual=(1, 40), help="tiles along x, from the easiest to the hardest")] = 10
    columns: Annotated[int, Integer(1, 1000, usual=(1, 40), help="tiles along y")] = 20
    difficulty: Annotated[
        Sequence[float], ListOf(Float(0, 1), 2, help="difficulty of the first row and of the last: 0 flat, 1 full")
    ] = (0.0, 1.0)
    gap: Annotated[int, Integer(0, 1000, unit="blocks", usual=(0, 20), help="flat ground between tiles")] = 0
    border: Annotated[int, Integer(0, 1000, unit="blocks", usual=(0, 20), help="flat ground around all tiles")] = 10
    name: Annotated[str, replace(parameters(Run)["name"], help="name of the terrain as a map")] = "terrain"
