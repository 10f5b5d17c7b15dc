"""Places at which the models of a map must be in a simulator, and at which they are."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

import rsegen
from rsegen.simulators.poses import Pose

Place = tuple[float, float, float]


def places(poses: Mapping[str, Pose]) -> dict[str, Place]:
    """To the micrometre."""
    return {name: micrometres(pose.x, pose.y, pose.z) for name, pose in poses.items()}


def expected_places(scene: rsegen.Scene) -> dict[str, Place]:
    """The ground, and the one mesh, or the pallets, or a box for each cell above the ground."""
    models = {"single": mesh, "pallet": pallets, "multi": boxes}[scene.recipe.mesh_type](scene)
    return {"ground_plane": (0.0, 0.0, 0.0)} | models


def mesh(scene: rsegen.Scene) -> dict[str, Place]:
    return {scene.name: (0.0, 0.0, 0.0)}


def pallets(scene: rsegen.Scene) -> dict[str, Place]:
    found = scene.field.chunks(scene.recipe.chunk_size)
    return {"pallet_{}_{}".format(*pallet.index): micrometres(*pallet.centre, 0) for pallet in found}


def boxes(scene: rsegen.Scene) -> dict[str, Place]:
    field = scene.field
    blocks = np.ndindex(*field.blocks.shape)
    x, y = (((line[:-1] + line[1:]) / 2).tolist() for line in field.edges())
    heights = field.heights.tolist()
    found = {}
    for i, j in np.ndindex(*field.shape):
        name = f"frame_{i}_{j}" if field.frame[i, j] else "block_{}_{}".format(*next(blocks))
        if heights[i][j]:
            found[name] = micrometres(x[i], y[j], heights[i][j] / 2)
    return found


def micrometres(x: float, y: float, z: float) -> Place:
    return round(x, 6), round(y, 6), round(z, 6)
