"""IsaacLab's `random_grid_terrain`, from the user's own installation, exported by trimesh.

The package starts a simulator when it is imported, so the one folder with this function is loaded without it. Heights
are drawn by the function itself; a border and a platform, without which it does not run, add 60 triangles.
"""

from __future__ import annotations

import importlib
import importlib.util
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import trimesh

from benchmarks.grids import BLOCK, Levels
from benchmarks.writers.boxes import exported


def _terrains() -> ModuleType:
    spec = importlib.util.find_spec("isaaclab")
    if spec is None:
        raise ModuleNotFoundError("isaaclab")
    inside = "terrains/trimesh"
    homes = [Path(at) / below / inside for at in spec.submodule_search_locations or () for below in ("", _SOURCE)]
    package = ModuleType("isaaclab_terrains")
    package.__path__ = [str(home) for home in homes if home.is_dir()]
    sys.modules[package.__name__] = package
    return importlib.import_module("isaaclab_terrains.mesh_terrains")


_SOURCE = "source/isaaclab/isaaclab"
_TERRAINS = _terrains()


def random_grid(levels: Levels, path: Path) -> int:
    """A terrain of as many blocks as the grid has, and as high."""
    side = (len(levels) + 0.5) * BLOCK
    wanted = SimpleNamespace(
        size=(side, side),
        grid_width=BLOCK,
        grid_height_range=(BLOCK, 5 * BLOCK),
        platform_width=BLOCK,
        holes=False,
    )
    meshes, _ = _TERRAINS.random_grid_terrain(1.0, wanted)
    return exported(trimesh.util.concatenate(meshes), path)
