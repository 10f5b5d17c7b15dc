"""rsegen, called here and nowhere else in the benchmarks, so that a change of its functions is a change here."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from benchmarks.grids import BLOCK, Levels
from rsegen import Placement, Random, Recipe, Scene, StepField
from rsegen.export import multi
from rsegen.export.obj import obj
from rsegen.geometry import Mesh, surface


def merged_obj(levels: Levels, path: Path) -> int:
    """The merged surface as OBJ."""
    mesh = merged(levels)
    _write(obj(mesh, "x.mtl"), path)
    return len(mesh.faces)


def multi_world(levels: Levels, path: Path) -> int:
    """A world with a box model for each block."""
    recipe = Recipe(name="x", seed=1, mesh_type="multi", obstacles=(Placement(obstacle=Random(max_height=6)),))
    scene = Scene(recipe=recipe, index=0, field=_field(levels))
    (world,) = multi.files(scene).values()
    _write(world, path)
    return multi.faces(scene)


def merged(levels: Levels) -> Mesh:
    """The merged surface of a grid."""
    return surface(_field(levels))


def _field(levels: Levels) -> StepField:
    frame = np.zeros(levels.shape, dtype=bool)
    return StepField(levels=levels, frame=frame, block_width=BLOCK, unit=BLOCK, frame_height=BLOCK)


def _write(pieces: Iterable[bytes], path: Path) -> None:
    with path.open("wb") as file:
        file.writelines(pieces)
