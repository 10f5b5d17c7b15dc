"""A bundle: the files of one map as bytes, before anything is written.

    Scene --export--> Bundle
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import PurePosixPath

from rsegen.codec import to_json
from rsegen.export import multi, pallet, single
from rsegen.export.levels import csv
from rsegen.recipe import Recipe
from rsegen.scene import Scene

Bundle = Mapping[PurePosixPath, Iterable[bytes]]
"""Where each file goes inside the map's folder, and its content piece by piece; to be read once."""

MESH_TYPES: Mapping[str, Callable[[Scene], dict[str, Iterable[bytes]]]] = {
    "single": single.files,
    "multi": multi.files,
    "pallet": pallet.files,
}


def export(scene: Scene) -> Bundle:
    """Everything on disk of a map: world and models as its mesh type says, its levels, and the recipe of it alone."""
    files = MESH_TYPES[scene.recipe.mesh_type](scene)
    files["levels.csv"] = csv(scene.field)
    files["recipe.json"] = [to_json(scene.alone).encode()]
    return {PurePosixPath(path): content for path, content in files.items()}
