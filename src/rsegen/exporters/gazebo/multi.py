"""Mesh type `multi`: every block and frame cell is a static model, a box that can be moved, deleted or copied."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from rsegen.exporters.gazebo import sdf
from rsegen.exporters.numbers import decimal
from rsegen.exporters.scene import Scene
from rsegen.field.stepfield import NANOMETRE_DIGITS, StepField


def files(scene: Scene) -> dict[str, Iterable[bytes]]:
    """The world file, generated while it is written."""
    return {f"{scene.name}.world": sdf.utf8(sdf.world(scene, boxes(scene)))}


def model_count(scene: Scene) -> int:
    """The number of cells above the ground."""
    field = scene.field
    frames = np.count_nonzero(field.frame) if 0 in _heights(field) else 0
    return int(np.count_nonzero(field.levels) + frames)


def collision_count(scene: Scene) -> int:
    """One collision shape per box."""
    return model_count(scene)


def boxes(scene: Scene) -> Iterator[str]:
    """The SDF text of one model per cell above the ground, row by row of x.

    Names are `block_X_Y` by block cell, `frame_I_J` by cell with frames counted.
    """
    field = scene.field
    x, y = ([decimal(at) for at in ((line[:-1] + line[1:]) / 2).tolist()] for line in field.edges())
    block_x, block_y = ((np.cumsum(field.inside(axis)) - 1).tolist() for axis in (0, 1))
    templates = {material: _template(scene, material, height) for material, height in _heights(field).items()}
    for i in range(field.shape[0]):
        row = zip(field.levels[i].tolist(), field.frame[i].tolist(), strict=True)
        yield "".join(
            templates[level] % (f"frame_{i}_{j}" if framed else f"block_{block_x[i]}_{block_y[j]}", x[i], y[j])
            for j, (level, framed) in enumerate(row)
            if framed * (0 in templates) or level
        )


def _heights(field: StepField) -> dict[int, float]:
    """The height of every material in metres, except those at z = 0."""
    heights = {level: level * field.unit or field.frame_height for level in [0, *field.level_counts()]}
    return {material: height for material, height in heights.items() if round(height, NANOMETRE_DIGITS)}


def _template(scene: Scene, material: int, height: float) -> str:
    """The model of a box with three placeholders: its name, x and y."""
    size = (scene.field.block_width, scene.field.block_width, height)
    visual = sdf.box("visual", size)._replace(material=sdf.material(scene.colour(material)))
    collision = sdf.box("collision", size)._replace(friction=scene.friction_of(material))
    return "".join(sdf.model("%s", [visual], [collision], f"%s %s {decimal(height / 2)}"))
