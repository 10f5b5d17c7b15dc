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

from rsegen.exporters.formats.parts import Column, columns
from rsegen.exporters.scene import Scene
from rsegen.field.stepfield import Array, Ints
from rsegen.learning.blocks import BlockArrays

_TORSIONAL, _ROLLING = 0.005, 0.0001
"""Friction coefficients, MuJoCo's defaults."""


def add_map(spec: Any, scene: Scene, pos: Sequence[float] = (0, 0, 0)) -> Any:
    """Add a map to an MjSpec as a static body of boxes, its middle at `pos` in metres; gives the body."""
    body = spec.worldbody.add_body(name=scene.name, pos=list(pos))
    for index, column in enumerate(columns(scene.field)):
        geom = add_box(body, column, scene.friction_of(column.material))
        geom.name = f"{scene.name}_{index}"
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


class BlockGrid(BlockArrays):
    """A box for each block of a map, whose heights change in place: a new map without compiling the model anew.

    The arrays of a map, or of many (..., n_x, n_y) at once, have an axis of blocks, x first, in the order of the geoms.
    """

    def add_to(self, spec: Any) -> Any:
        """Add the blocks to an MjSpec as a static body, all as high as the highest; gives the body.

        What the compiler makes of their size, the bounds in which it looks for contacts, then holds for every map.
        """
        body = spec.worldbody.add_body(name=self.name, pos=list(self.position))
        arrays = (part(self.highest) for part in (self.pos, self.size, self.rgba, self.friction))
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

    def friction(self, levels: Ints) -> Array:
        """The friction coefficients of the blocks by their levels, (..., blocks, 3): sliding, torsional, rolling."""
        sliding = self.sliding(levels)[..., None]
        return np.concatenate([sliding, np.broadcast_to((_TORSIONAL, _ROLLING), (*sliding.shape[:-1], 2))], axis=-1)
