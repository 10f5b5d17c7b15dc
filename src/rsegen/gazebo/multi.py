"""Mesh type `multi`: every block and frame cell is a static model, a box that can be moved, deleted or copied."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from rsegen.field.stepfield import StepField
from rsegen.gazebo import sdf, shapes
from rsegen.gazebo.obj import material_name, obj
from rsegen.geometry import surface
from rsegen.params.numbers import decimal
from rsegen.params.sorts import NANOMETRE_DIGITS
from rsegen.scene.scene import Scene


def files(scene: Scene) -> dict[str, Iterable[bytes]]:
    """Return the world file, generated while it is written, and the meshes of textured blocks, VARIANTS per level."""
    contents: dict[str, Iterable[bytes]] = {f"{scene.name}.world": sdf.utf8(sdf.world(scene, block_models(scene)))}
    for material in _heights(scene.field) if scene.recipe.is_textured else ():
        for variant in range(VARIANTS):
            # A row of cells with one block or frame, whose cell decides its texture.
            levels, frame = np.zeros((VARIANTS, 1), dtype=np.int16), np.zeros((VARIANTS, 1), dtype=bool)
            levels[variant], frame[variant] = material, not material
            block = replace(scene.field, levels=levels, frame=frame)
            mesh = obj([surface(block)], f"{scene.name}.mtl", block)
            contents[f"meshes/{_mesh_name(scene, material, variant)}"] = mesh
    return contents | (shapes.material_files(scene) if len(contents) > 1 else {})


def counts(scene: Scene) -> tuple[int, int]:
    """Return the number of cells above the ground twice, as each is a model with one collision shape."""
    field = scene.field
    frames = np.count_nonzero(field.frame) if 0 in _heights(field) else 0
    models = int(np.count_nonzero(field.levels) + frames)
    return models, models


def block_models(scene: Scene) -> Iterator[str]:
    """Yield the SDF text of one model per cell above the ground, row by row of x.

    Names are `block_X_Y` by block cell, `frame_I_J` by cell with frames counted.
    """
    field = scene.field
    x, y = ([decimal(at) for at in line.tolist()] for line in field.middles())
    block_x, block_y = (field.numbered(axis).tolist() for axis in (0, 1))
    # A model differs from others of its material in name, x and y only, so it is one text with three placeholders.
    templates = {material: _templates(scene, material, height) for material, height in _heights(field).items()}
    for i in range(field.shape[0]):
        row = zip(field.levels[i].tolist(), field.frame[i].tolist(), strict=True)
        yield "".join(
            templates[level][(i + 2 * j) % VARIANTS]
            % (f"frame_{i}_{j}" if framed else f"block_{block_x[i]}_{block_y[j]}", x[i], y[j])
            for j, (level, framed) in enumerate(row)
            if framed * (0 in templates) or level
        )


def _heights(field: StepField) -> dict[int, float]:
    """Return the height of every material in metres, except those at z = 0."""
    heights = {level: level * field.unit or field.frame_height for level in [0, *field.level_counts()]}
    return {material: height for material, height in heights.items() if round(height, NANOMETRE_DIGITS)}


VARIANTS = 4
"""Different textures of the blocks of a level: (i + 2 j) % 4 gives a block and its four neighbours different ones but
for one pair; each is a mesh file."""


def _templates(scene: Scene, material: int, height: float) -> list[str]:
    """Return the models of a box, one per variant, each with three placeholders: its name, x and y."""
    width = scene.field.block_width
    collision = sdf.box_geometry("collision", (width, width, height))._replace(friction=scene.friction_of(material))
    visual = sdf.box_geometry("visual", (width, width, height))._replace(material=sdf.material(scene.colour(material)))
    visuals = [visual] * VARIANTS
    if scene.recipe.is_textured:
        # A mesh has its block in one of several cells, and is moved until that is in the middle.
        visuals = [
            sdf.mesh_geometry("visual", f"meshes/{_mesh_name(scene, material, variant)}")._replace(
                centre=((VARIANTS - 1 - 2 * variant) / 2 * width, 0, -height / 2)
            )
            for variant in range(VARIANTS)
        ]
    place = f"%s %s {decimal(height / 2)}"
    return ["".join(sdf.model("%s", [visual], [collision], place)) for visual in visuals]


def _mesh_name(scene: Scene, material: int, variant: int) -> str:
    return f"{scene.name}_{material_name(material)}_{variant}.obj"
