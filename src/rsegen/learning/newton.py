"""Newton: a map as static shapes of a ModelBuilder, and blocks whose map changes in a finalized model (1.8).

from rsegen.learning.newton import BlockGrid, add_map

builder = newton.ModelBuilder()
add_map(builder, rsegen.compose(recipe, 17))
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import newton
import numpy as np
import warp as wp

from rsegen.errors import ParameterError, UnknownName, refuse_other
from rsegen.field.stepfield import Array, Ints
from rsegen.geometry.box_merging import columns
from rsegen.geometry.watertight_mesh import watertight
from rsegen.learning.blocks import BlockArrays
from rsegen.learning.ground import position_of
from rsegen.scene.scene import Scene

SHAPES = ("boxes", "mesh")

_TOUCHES_ALL = -(2**20)
"""A collision group: one below 0 collides with all others but itself, so it is one that nobody else would take."""


def add_map(builder: Any, scene: Scene, pos: Sequence[float] = (0, 0, 0), shape: str = "boxes") -> list[int]:
    """Add a map to a ModelBuilder, its middle at `pos` in metres; gives the indices of its shapes.

    shape: `boxes` of one level each, or a closed `mesh` for each friction coefficient. Each has its own friction.
    """
    refuse_other("scene", scene, Scene)
    if shape not in SHAPES:
        raise UnknownName.among("shape", "shape", shape, SHAPES)
    at = position_of(pos)
    if shape == "boxes":
        return [
            _add_box(
                builder,
                at + column.centre,
                np.array(column.size) / 2,
                friction=scene.friction_of(column.material),
                colour=scene.colour(column.material),
            )
            for column in columns(scene.field)
        ]
    shapes = []  # a shape has one friction coefficient
    for friction, materials in scene.by_friction(scene.field):
        solid = watertight(scene.field if materials is None else scene.field.only(materials))
        if len(solid.faces):
            mesh = newton.Mesh(solid.vertices.astype(np.float32), solid.triangles.ravel().astype(np.int32))
            place = wp.transform(wp.vec3(*at), wp.quat_identity())
            shapes.append(builder.add_shape_mesh(-1, xform=place, mesh=mesh, cfg=_config(builder, friction)))
    return shapes


def _add_box(builder: Any, centre: Array, half: Array, *, friction: float, colour: Sequence[float]) -> int:
    return int(
        builder.add_shape_box(
            -1,
            xform=wp.transform(wp.vec3(*centre), wp.quat_identity()),
            **dict(zip(("hx", "hy", "hz"), half.tolist(), strict=True)),
            cfg=_config(builder, friction),
            color=tuple(colour),
        )
    )


def _config(builder: Any, friction: float) -> Any:
    """Return the builder's own stiffness of shapes, but all that decides whether they touch, whatever it is there."""
    config = builder.default_shape_cfg.copy()
    config.mu, config.collision_group = friction, _TOUCHES_ALL
    config.has_shape_collision = config.has_particle_collision = config.is_visible = True
    config.margin, config.gap, config.is_site, config.is_hydroelastic = 0.0, None, False, False
    return config


class BlockGrid(BlockArrays):
    """A box for each block of a map, whose heights change in place: a new map without finalizing the model anew."""

    def add_to(self, builder: Any) -> list[int]:
        """Add the blocks to a ModelBuilder as static shapes, all as high as the highest; gives their indices.

        The bounds that Newton keeps of them then hold for every map. In copies of a builder (`replicate`, without
        spacing), the indices of world k are `shape_count * k` greater.
        """
        arrays = (part(self.highest) for part in (self.pos, self.size, self.sliding, self.rgba))
        return [
            _add_box(builder, centre, half, friction=float(friction), colour=rgba[:3].tolist())
            for centre, half, friction, rgba in zip(*arrays, strict=True)
        ]

    def write(self, model: Any, levels: Ints, shapes: Sequence[int] | Ints) -> None:
        """Put maps (..., n_x, n_y) into the shapes (..., blocks) of a finalized model, in place.

        A solver that keeps shapes of its own has to be notified:
        `solver.notify_model_changed(newton.ModelFlags.SHAPE_PROPERTIES)`.
        """
        # The rows of the shapes in four arrays of the model, on its device.
        indices, centres = np.asarray(shapes).reshape(-1), self.pos(levels)
        if len(indices) != centres[..., 0].size:
            raise ParameterError("shapes", f"{len(indices)} for {centres[..., 0].size} blocks; pass those of add_to")
        if not len(indices):
            return
        if not 0 <= indices.min() <= indices.max() < model.shape_count:
            raise ParameterError("shapes", f"{indices.min()}..{indices.max()} of {model.shape_count} shapes")
        upright = np.broadcast_to((0.0, 0.0, 0.0, 1.0), (*centres.shape[:-1], 4))  # a quaternion, w last
        for array, values in (
            (model.shape_transform, np.concatenate([centres, upright], axis=-1)),
            (model.shape_scale, self.size(levels)),
            (model.shape_material_mu, self.sliding(levels)[..., None]),
            (model.shape_color, self.rgba(levels)[..., :3]),
        ):
            places: Any = wp.array(indices, dtype=wp.int32, device=array.device)
            rows: Any = wp.array(values.reshape(len(indices), -1).squeeze(), dtype=array.dtype, device=array.device)
            written: Any = wp.indexedarray(array, [places])
            wp.copy(written, rows)
