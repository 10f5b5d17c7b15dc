"""From a recipe to a map.

    Recipe --build--> StepField

Each obstacle is asked once for its levels, with its own generator, and is imposed on those before it; then the map is
eased to its difficulty; then come frames, and what the map is to keep to.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from rsegen.chance import SEEDS, generator
from rsegen.constraints import constrained
from rsegen.difficulty import eased
from rsegen.errors import ParameterError, TooLarge
from rsegen.obstacles import Grid, Patch
from rsegen.params import Whole
from rsegen.places import Cell
from rsegen.recipe import Placement, Recipe
from rsegen.stepfield import Levels, StepField, framed


def build(recipe: Recipe, index: int = 0) -> StepField:
    """Map `index` of a recipe: the same, whichever other maps are made; `index` is 0 or more."""
    index = Whole(0, SEEDS - 1).check("index", index)
    grid = recipe.grid
    levels = _level_ground(grid)
    for number, placement in enumerate(recipe.obstacles):
        try:
            *_, patch = placed(recipe, placement, index)
        except ParameterError as error:
            raise error.inside(f"obstacles[{number}]") from None
        _impose(levels, patch, placement.blend, recipe.top_level)
    levels = eased(levels, recipe, index)
    levels, frame = framed(levels, recipe.chunk_size, recipe.boundary)
    field = StepField(
        levels=levels,
        frame=frame,
        block_width=recipe.block_width_cm / 100,
        unit=recipe.unit_cm / 100,
        frame_height=recipe.frame_height_cm / 100,
    )
    return constrained(field, recipe, index)


def _level_ground(grid: Grid) -> Levels:
    try:
        return np.zeros(grid.shape, dtype=np.int16)
    except (MemoryError, OverflowError, ValueError):
        raise TooLarge(f"chunks: a map of {grid.n_x} x {grid.n_y} blocks is more than this machine's memory") from None


def placed(recipe: Recipe, placement: Placement, index: int) -> tuple[Cell, Cell, Patch]:
    """Where the ends of a recipe's obstacle are in map `index`, and the levels that it proposes."""
    obstacle, grid = placement.obstacle, recipe.grid
    usual_first, usual_last = obstacle.usual_ends(grid)
    rng = generator(recipe.seed, index, placement.key or "")
    first, last = obstacle.ends(grid, placement.first or usual_first, placement.last or usual_last, rng)
    return first, last, obstacle.patch(grid, first, last, rng)


def _impose(levels: Levels, patch: Patch, blend: str, top_level: int) -> None:
    below = levels[patch.window]
    np.copyto(below, _BLENDS[blend](below, patch.levels, top_level), where=patch.footprint)


_Blend = Callable[[NDArray[np.int16], NDArray[np.int16], int], NDArray[np.integer]]
_BLENDS: dict[str, _Blend] = {
    "replace": lambda below, own, top: own,
    "max": lambda below, own, top: np.maximum(below, own),
    "min": lambda below, own, top: np.minimum(below, own),
    "add": lambda below, own, top: np.minimum(below.astype(np.int32) + own, top).astype(np.int16),
}
