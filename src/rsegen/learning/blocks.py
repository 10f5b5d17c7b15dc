"""A box for each block of a map, as arrays: what engines write in place to change a map without compiling anew."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np

from rsegen.errors import ParameterError, refuse_other
from rsegen.field.stepfield import Array, Ints
from rsegen.learning.ground import Ground, check_levels, friction_by_level, position_of, unframed
from rsegen.recipe.recipe import Recipe
from rsegen.scene.contact import CONTACT, Contact
from rsegen.scene.scene import Scene

GROUND_COLOUR = (0.6, 0.6, 0.6)

BELOW = 0.1
"""Metres that the blocks of a grid reach below the ground, so that blocks of level 0 have a size."""


class BlockArrays:
    """The blocks of the maps of a recipe; `pos`: where the middle of the map is in the world, metres.

    colours, frictions: of each level, (levels, 4) and (levels,)

    The arrays of a map, or of many (..., n_x, n_y) at once, have an axis of blocks, x first.
    """

    contact: Contact = CONTACT

    def __init__(self, recipe: Recipe, name: str = "block", pos: Sequence[float] = (0, 0, 0)) -> None:
        refuse_other("recipe", recipe, Recipe)
        if recipe.boundary != "none":
            raise ParameterError("boundary", f"'{recipe.boundary}' has frames, and a grid has only blocks; use none")
        self.recipe: Recipe = recipe
        self.name: str = name
        self.position: Array = position_of(pos)
        self.shape: tuple[int, int] = recipe.grid.shape
        width, unit = recipe.block_width_cm / 100, recipe.unit_cm / 100
        # A flat map has the edges of all maps, and its scene the colours of all levels.
        field = unframed(np.zeros(self.shape, dtype=np.int16), width, unit)
        look = Scene(recipe=recipe, index=0, field=field)
        levels = range(1, recipe.highest_level + 1)
        self.colours = np.array([(*colour, 1.0) for colour in (GROUND_COLOUR, *map(look.colour, levels))])
        self.frictions = friction_by_level(recipe)
        self._x, self._y = (edges[:-1] + width / 2 for edges in field.edges())
        self._half, self._unit = width / 2, unit

    def ground(self, levels: Any) -> Ground:
        """Return the ground of these blocks: of a map (n_x, n_y), or of worlds (worlds, n_x, n_y)."""
        ground = Ground(self.recipe, levels, self.position, contact=self.contact)
        self._refuse_other_shape(tuple(ground.levels.shape))
        return ground

    @cached_property
    def names(self) -> list[str]:
        """The names of the blocks."""
        n_x, n_y = self.shape
        return [f"{self.name}_{i}_{j}" for i in range(n_x) for j in range(n_y)]

    @property
    def highest(self) -> Ints:
        """The levels of a map whose blocks are all as high as the highest, (n_x, n_y)."""
        return np.full(self.shape, self.recipe.highest_level)

    def pos(self, levels: Ints) -> Array:
        """The centres of the blocks in the world, (..., blocks, 3), metres."""
        heights = self._heights(levels)
        centres = np.empty((*heights.shape, 3))
        # A block reaches from BELOW under the ground up to its height.
        centres[..., 0], centres[..., 1], centres[..., 2] = self._x[:, None], self._y, (heights - BELOW) / 2
        return _rows(centres + self.position)

    def size(self, levels: Ints) -> Array:
        """Half of the sides of the blocks, (..., blocks, 3), metres."""
        halves = np.full((*np.shape(levels), 3), self._half)
        halves[..., 2] = (self._heights(levels) + BELOW) / 2
        return _rows(halves)

    def rgba(self, levels: Ints) -> Array:
        """The colours of the blocks by their levels, (..., blocks, 4), from 0 to 1."""
        return _rows(self.colours[self._checked(levels)])

    def sliding(self, levels: Ints) -> Array:
        """The coefficients of sliding friction of the blocks by their levels, (..., blocks)."""
        return _rows(self.frictions[self._checked(levels)][..., None])[..., 0]

    def _heights(self, levels: Ints) -> Array:
        return np.asarray(self._checked(levels) * self._unit, dtype=float)

    def _checked(self, levels: Ints) -> Ints:
        """Return levels as an array; ParameterError unless they fit a map of the recipe."""
        own = np.asarray(levels)
        if own.dtype.kind not in "iu":
            raise ParameterError("levels", f"of {own.dtype}; expected integers, in units")
        self._refuse_other_shape(own.shape)
        if own.size:
            check_levels(own, self.recipe.highest_level)
        return own

    def _refuse_other_shape(self, shape: tuple[int, ...]) -> None:
        if shape[-2:] != self.shape:
            raise ParameterError("levels", f"of shape {shape} for a grid of {self.shape}")


def _rows(values: Array) -> Array:
    """Return values with an axis of blocks in place of the two axes of cells."""
    *many, n_x, n_y, numbers = values.shape  # not -1 for the blocks, as there may be no maps
    return values.reshape(*many, n_x * n_y, numbers)
