"""SAPIEN and ManiSkill: a map as static boxes of an ActorBuilder (SAPIEN 3.0).

from rsegen.learning.sapien import add_map

builder = scene.create_actor_builder()
add_map(builder, rsegen.compose(recipe, 17))
builder.build_static(name="rubble")
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

import sapien
from sapien.physx import PhysxMaterial

from rsegen.errors import refuse_other
from rsegen.geometry.box_merging import columns
from rsegen.learning.ground import position_of
from rsegen.scene.scene import Scene


def add_map(builder: Any, scene: Scene, pos: Sequence[float] = (0, 0, 0), *, visual: bool = True) -> int:
    """Add a map to an ActorBuilder, its middle at `pos` in metres; gives the number of its boxes.

    Each box has one level, its friction and its colour; nothing rebounds from it. Level 0 has no box, so add a plane.
    visual: boxes can be seen, for which SAPIEN needs a GPU
    """

    @cache
    def material(friction: float) -> Any:
        return PhysxMaterial(friction, friction, 0.0)

    refuse_other("scene", scene, Scene)
    count, middle = 0, position_of(pos)
    for column in columns(scene.field):
        place = sapien.Pose((middle + column.centre).tolist())
        half = tuple(side / 2 for side in column.size)
        builder.add_box_collision(place, half, material(scene.friction_of(column.material)))
        if visual:
            builder.add_box_visual(place, half, tuple(scene.colour(column.material)[:3]))
        count += 1
    return count
