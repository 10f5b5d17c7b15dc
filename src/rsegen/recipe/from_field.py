"""The recipe of a field: its blocks as a matrix, in chunks that its frames show."""

from __future__ import annotations

import math

import numpy as np

from rsegen.errors import refuse_other
from rsegen.field.stepfield import StepField
from rsegen.obstacles.matrix import Matrix
from rsegen.recipe.recipe import Recipe


def recipe_of(field: StepField) -> Recipe:
    """Return a recipe whose map is a field: its blocks as a matrix, and its frames.

    Parameters
    ----------
    field : StepField
        The field.

    Returns
    -------
    Recipe
        The recipe; `build` makes the field of it again.
    """
    refuse_other("field", field, StepField)
    sides = [int(field.inside(axis).sum()) for axis in (0, 1)]
    chunk_size, boundary = largest_chunk(*sides), "none"
    if field.frame.any():
        # A frame is one cell deep; the blocks up to the next one are a chunk's, or the map's.
        runs = [int(np.argmin([*field.inside(axis)[1:], False])) for axis in (0, 1)]
        chunk_size, boundary = (chunk_size, "outer") if runs == sides else (runs[0], "divided")
    return Recipe(
        chunk_size=chunk_size,
        chunks=(sides[0] // chunk_size, sides[1] // chunk_size),
        unit_cm=round(100 * field.unit, 9),
        block_width_cm=round(100 * field.block_width, 9),
        frame_height_cm=round(100 * field.frame_height, 9),
        boundary=boundary,
        seed=0,
        obstacles=(Matrix.of(field.blocks),),
    )


def largest_chunk(n_x: int, n_y: int) -> int:
    """Return the largest side of chunks of which a map of n_x x n_y blocks can be made."""
    common = math.gcd(n_x, n_y)
    return next(common // parts for parts in range(1, common + 1) if not common % parts and common // parts <= _MOST)


_MOST = 1000
"""Blocks along the side of a chunk at most (`MapDesign.chunk_size`)."""
