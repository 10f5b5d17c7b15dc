"""MuJoCo: a map as a body of an MjSpec, and blocks whose map changes in a compiled model.

spec = mujoco.MjSpec.from_file("robot.xml")
grid = BlockGrid(recipe)
grid.add_to(spec)
model = spec.compile()
grid.write(model, rsegen.build_many(recipe, [17])[0])
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np

from rsegen.errors import ParameterError
from rsegen.exporters.formats.columns import Column, columns
from rsegen.exporters.scene import Scene
from rsegen.field.stepfield import Array, Ints, StepField
from rsegen.recipe.recipe import Recipe

GROUND_COLOUR = (0.6, 0.6, 0.6)

_TORSIONAL, _ROLLING = 0.005, 0.0001
"""Friction coefficients, MuJoCo's defaults."""

_DEPTH = 0.1
"""Metres that the blocks of a grid reach below the ground, so that those of level 0 have a size."""


def add_map(spec: Any, scene: Scene, pos: Sequence[float] = (0, 0, 0)) -> Any:
    """Add a map to an MjSpec as a static body of boxes, its middle at `pos` in metres; gives the body."""
    body = spec.worldbody.add_body(name=scene.name, pos=list(pos))
    for number, column in enumerate(columns(scene.field)):
        geom = add_box(body, column, scene.friction_of(column.material))
        geom.name = f"{scene.name}_{number}"
        geom.rgba = [*scene.colour(column.material), 1.0]
    return body


def add_box(body: Any, column: Column, friction: float) -> Any:
    """Add a box to a body of an MjSpec; it has no mass, as it cannot move. Gives the geom."""
    return body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX,
        pos=list(column.centre),
        size=[side / 2 for side in column.size],
        friction=[friction, _TORSIONAL, _ROLLING],
        mass=0,
    )


class BlockGrid:
    """A box for each block of a map, whose heights change in place: a new map without compiling the model anew.

    The arrays of a map, or of many (..., n_x, n_y) at once, have an axis of blocks, x first, in the order of the geoms:
    they can be written into the models of mujoco_warp and MJX too, a map for each world.
    """

    def __init__(self, recipe: Recipe, name: str = "block", pos: Sequence[float] = (0, 0, 0)) -> None:
        if recipe.boundary != "none":
            raise ParameterError(
                "boundary", f"'{recipe.boundary}' has frames, and a grid is of blocks alone; give none"
            )
        self.recipe, self.name, self.position = recipe, name, np.array(pos, dtype=float)
        self.shape = recipe.grid.shape
        flat = np.zeros(self.shape, dtype=np.int16)
        width, unit = recipe.block_width_cm / 100, recipe.unit_cm / 100
        field = StepField(levels=flat, frame=flat > 0, block_width=width, unit=unit, frame_height=0.0)
        look = Scene(recipe=recipe, index=0, field=field)
        levels = range(1, recipe.highest_level + 1)
        self._rgba = np.array([(*colour, 1.0) for colour in (GROUND_COLOUR, *map(look.colour, levels))])
        self._friction = np.array([recipe.friction, *map(look.friction_of, levels)])
        self._x, self._y = (edges[:-1] + width / 2 for edges in field.edges())
        self._half, self._unit = width / 2, unit

    @property
    def names(self) -> list[str]:
        """The names of the geoms."""
        n_x, n_y = self.shape
        return [f"{self.name}_{i}_{j}" for i in range(n_x) for j in range(n_y)]

    def add_to(self, spec: Any) -> Any:
        """Add the blocks to an MjSpec as a static body, all as high as the highest; gives the body.

        What the compiler makes of their size, the bounds in which it looks for contacts, then holds for every map.
        """
        body = spec.worldbody.add_body(name=self.name, pos=list(self.position))
        highest = np.full(self.shape, self.recipe.highest_level)
        arrays = (self.pos(highest), self.size(highest), self.rgba(highest), self.friction(highest))
        for name, pos, size, rgba, friction in zip(self.names, *arrays, strict=True):
            geom = body.add_geom(name=name, type=mujoco.mjtGeom.mjGEOM_BOX, pos=pos, size=size, mass=0)
            geom.rgba, geom.friction = rgba, friction
        return body

    def write(self, model: Any, levels: Ints) -> None:
        """Put the map of these levels (n_x, n_y) into a compiled model, in place."""
        first = model.geom(self.names[0]).id
        part = slice(first, first + len(self.names))
        model.geom_pos[part], model.geom_size[part] = self.pos(levels), self.size(levels)
        model.geom_rgba[part], model.geom_friction[part] = self.rgba(levels), self.friction(levels)

    def pos(self, levels: Ints) -> Array:
        """The centres of the blocks in their body, (..., blocks, 3), metres."""
        x, y = np.broadcast_to(self._x[:, None], self.shape), np.broadcast_to(self._y, self.shape)
        found = np.empty((*np.shape(levels), 3))
        found[..., 0], found[..., 1], found[..., 2] = x, y, (self._heights(levels) - _DEPTH) / 2
        return self._rows(found)

    def size(self, levels: Ints) -> Array:
        """Half of the sides of the blocks, (..., blocks, 3), metres."""
        found = np.full((*np.shape(levels), 3), self._half)
        found[..., 2] = (self._heights(levels) + _DEPTH) / 2
        return self._rows(found)

    def rgba(self, levels: Ints) -> Array:
        """The colours of the blocks by their levels, (..., blocks, 4), from 0 to 1."""
        return self._rows(self._rgba[np.asarray(levels)])

    def friction(self, levels: Ints) -> Array:
        """The friction coefficients of the blocks by their levels, (..., blocks, 3): sliding, torsional, rolling."""
        found = np.empty((*np.shape(levels), 3))
        found[..., 0], found[..., 1:] = self._friction[np.asarray(levels)], (_TORSIONAL, _ROLLING)
        return self._rows(found)

    def _heights(self, levels: Ints) -> Array:
        if np.shape(levels)[-2:] != self.shape:
            raise ParameterError("levels", f"of shape {np.shape(levels)} for a grid of {self.shape}")
        return np.asarray(np.asarray(levels) * self._unit, dtype=float)

    def _rows(self, values: Array) -> Array:
        return values.reshape(*values.shape[:-3], -1, values.shape[-1])
