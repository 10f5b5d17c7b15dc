"""Newton: a map as static shapes of a ModelBuilder (1.8).

from rsegen.learning.newton import add_map

builder = newton.ModelBuilder()
add_map(builder, rsegen.compose(recipe, 17))
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import newton
import numpy as np
import warp as wp

from rsegen.errors import UnknownName
from rsegen.exporters.formats.columns import columns
from rsegen.exporters.scene import Scene

SHAPES = ("boxes", "mesh")


def add_map(builder: Any, scene: Scene, pos: Sequence[float] = (0, 0, 0), shape: str = "boxes") -> list[int]:
    """Add a map to a ModelBuilder, its middle at `pos` in metres; gives the indices of its shapes.

    shape: `boxes` of one level each, or a closed `mesh` for each friction coefficient. Each has its own friction.
    """
    if shape not in SHAPES:
        raise UnknownName.among("shape", "shape", shape, SHAPES)
    at = np.array(pos, dtype=float)
    return _add_boxes(builder, scene, at) if shape == "boxes" else _add_meshes(builder, scene, at)


def _add_boxes(builder: Any, scene: Scene, at: np.ndarray) -> list[int]:
    return [
        builder.add_shape_box(
            -1,
            xform=wp.transform(wp.vec3(*(at + column.centre)), wp.quat_identity()),
            **dict(zip(("hx", "hy", "hz"), (side / 2 for side in column.size), strict=True)),
            cfg=_config(builder, scene.friction_of(column.material)),
            color=scene.colour(column.material),
        )
        for column in columns(scene.field)
    ]


def _add_meshes(builder: Any, scene: Scene, at: np.ndarray) -> list[int]:
    found = []
    for friction, materials in scene.by_friction(scene.field):
        field = scene.field if materials is None else scene.field.only(materials)
        mesh = field.mesh("watertight")
        if len(mesh.faces):
            shape = newton.Mesh(mesh.vertices.astype(np.float32), mesh.triangles.ravel().astype(np.int32))
            place = wp.transform(wp.vec3(*at), wp.quat_identity())
            found.append(builder.add_shape_mesh(-1, xform=place, mesh=shape, cfg=_config(builder, friction)))
    return found


def _config(builder: Any, friction: float) -> Any:
    config = builder.default_shape_cfg.copy()
    config.mu = friction
    return config
