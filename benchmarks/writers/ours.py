"""rsegen, called here and nowhere else in the benchmarks, so that a change of its functions is a change here."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from benchmarks.grids import BLOCK, Levels
from rsegen import Random, Recipe, Scene, StepField
from rsegen.gazebo import multi
from rsegen.gazebo.obj import face_count, obj
from rsegen.geometry import meshes


def merged_obj(levels: Levels, path: Path) -> int:
    """The merged surface as OBJ."""
    return _obj(levels, "merged", path)


def watertight_obj(levels: Levels, path: Path) -> int:
    """The closed surface as OBJ."""
    return _obj(levels, "watertight", path)


def blocks_obj(levels: Levels, path: Path) -> int:
    """8 vertices and 6 faces a block as OBJ."""
    return _obj(levels, "blocks", path)


def multi_world(levels: Levels, path: Path) -> int:
    """A world with a box model for each block."""
    recipe = Recipe(name="x", seed=1, mesh_type="multi", obstacles=(Random(levels=6),))
    scene = Scene(recipe=recipe, index=0, field=_field(levels))
    (world,) = multi.files(scene).values()
    _write(world, path)
    return 6 * multi.counts(scene)[0]


def merged(levels: Levels) -> int:
    """Number of faces that the merged surface of a grid has."""
    return sum(len(mesh.faces) for mesh in meshes(_field(levels), "merged"))


def _obj(levels: Levels, mesh: str, path: Path) -> int:
    found = 0
    with path.open("wb") as file:
        for piece in obj(meshes(_field(levels), mesh), "x.mtl"):
            found += face_count(piece)
            file.write(piece)
    return found


def _field(levels: Levels) -> StepField:
    frame = np.zeros(levels.shape, dtype=bool)
    return StepField(levels=levels, frame=frame, block_width=BLOCK, unit=BLOCK, frame_height=BLOCK)


def _write(pieces: Iterable[bytes], path: Path) -> None:
    with path.open("wb") as file:
        file.writelines(pieces)
