"""The bundle of one map: its files as bytes, before they are written."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from pathlib import PurePosixPath
from typing import Protocol

from rsegen.gazebo import multi, pallet, single
from rsegen.recipe.codec import map_json
from rsegen.scene.scene import Scene, csv

Bundle = Mapping[PurePosixPath, Iterable[bytes]]
"""The content of each file in chunks of bytes by its path in the map's folder; to be read once."""


class MeshType(Protocol):
    """A way to make models of a map: a module of this package with these three functions."""

    def files(self, scene: Scene) -> dict[str, Iterable[bytes]]:
        """Return the world file and all other files that it needs."""

    def model_count(self, scene: Scene) -> int:
        """Return the number of models in the world."""

    def collision_count(self, scene: Scene) -> int:
        """Return the number of collision shapes in the world."""


MESH_TYPES: Mapping[str, MeshType] = {"single": single, "multi": multi, "pallet": pallet}


def export(scene: Scene) -> Bundle:
    """Return all files of a map: world and models by its mesh type, levels, its recipe, the constraint report."""
    files = MESH_TYPES[scene.recipe.mesh_type].files(scene)
    files["levels.csv"] = csv(scene.field)
    if scene.recipe.is_constrained:
        from rsegen.gazebo.constraint_report import constraint_report

        files["constraints.json"] = [(json.dumps(constraint_report(scene), indent=2) + "\n").encode()]
    files["recipe.json"] = [map_json(scene.recipe, scene.index)]
    return {PurePosixPath(path): content for path, content in files.items()}
