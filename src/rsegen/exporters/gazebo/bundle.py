"""A bundle: the files of one map as bytes, before anything is written.

Scene --export--> Bundle
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from pathlib import PurePosixPath
from typing import Protocol

from rsegen.exporters.constraint_report import constraint_report
from rsegen.exporters.gazebo import multi, pallet, single
from rsegen.exporters.levels import csv
from rsegen.exporters.scene import Scene
from rsegen.recipe.codec import map_json

Bundle = Mapping[PurePosixPath, Iterable[bytes]]
"""Where each file goes inside the map's folder, and its content piece by piece; to be read once."""


class MeshType(Protocol):
    """One way to make models of a map: a file of this folder with these three functions."""

    def files(self, scene: Scene) -> dict[str, Iterable[bytes]]:
        """The world, and whatever it needs beside it."""

    def model_count(self, scene: Scene) -> int:
        """How many models the world has."""

    def collision_count(self, scene: Scene) -> int:
        """How many shapes can be touched in it."""


MESH_TYPES: Mapping[str, MeshType] = {"single": single, "multi": multi, "pallet": pallet}


def export(scene: Scene) -> Bundle:
    """Everything on disk of a map: world and models as its mesh type says, its levels, the recipe of it alone, and
    the proof that it keeps to its constraints.
    """
    files = MESH_TYPES[scene.recipe.mesh_type].files(scene)
    files["levels.csv"] = csv(scene.field)
    if scene.recipe.is_constrained:
        files["constraints.json"] = [(json.dumps(constraint_report(scene), indent=2) + "\n").encode()]
    files["recipe.json"] = [map_json(scene.recipe, scene.index)]
    return {PurePosixPath(path): content for path, content in files.items()}
