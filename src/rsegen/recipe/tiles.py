"""A map as a tile of a larger terrain: its cells are levels, frames too, and its difficulty is a share of its own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rsegen.errors import ParameterError, shown
from rsegen.field.stepfield import Array, Ints, Levels
from rsegen.recipe.building import build
from rsegen.recipe.recipe import Recipe


def check_tile(recipe: Recipe) -> None:
    """Raise a ParameterError if the maps of a recipe cannot be tiles."""
    if isinstance(recipe.difficulty, tuple):
        given = shown(list(recipe.difficulty))
        raise ParameterError("difficulty", f"{given} is a range, and tiles have their own; give one number")
    if recipe.boundary != "none" and recipe.frame_height_cm % recipe.unit_cm:
        problem = f"{recipe.frame_height_cm:g} is no multiple of the unit, {recipe.unit_cm:g}"
        raise ParameterError("frame_height_cm", f"{problem}; the frames of a tile are blocks like others")


def tile_shape(recipe: Recipe) -> tuple[int, int]:
    """Cells of a map along x and y, frames counted."""
    n_x, n_y = recipe.grid.shape
    if recipe.boundary == "none":
        return n_x, n_y
    frames_x, frames_y = recipe.chunks if recipe.boundary == "divided" else (1, 1)
    return n_x + 2 * frames_x, n_y + 2 * frames_y


def amid(levels: Ints | Array) -> Ints | Array:
    """The highest of the cells that meet in the middle of each map, (...,), of levels or heights (..., n_x, n_y)."""
    x, y = (slice((cells - 1) // 2, cells // 2 + 1) for cells in levels.shape[-2:])
    return np.asarray(levels[..., x, y].max(axis=(-2, -1)))


def eased(recipe: Recipe, share: float) -> Recipe:
    """The recipe at a share of its difficulty, which is one number."""
    return replace(recipe, difficulty=float(share) * recipe.difficulty)  # type: ignore[operator]  # one number


def tile_levels(recipe: Recipe, index: int) -> Levels:
    """The levels of the cells of map `index`, frames as blocks of their height: (n_x, n_y)."""
    field = build(recipe, index)
    frame = round(recipe.frame_height_cm / recipe.unit_cm)
    return np.where(field.frame, np.int16(frame), field.levels).astype(np.int16)
