"""Isaac Lab: step fields as sub-terrains of its TerrainGenerator (2.3, 3.0).

from isaaclab.terrains import SubTerrainBaseCfg
from rsegen.learning.isaaclab import StepFieldTerrain

sub_terrains = {"rubble": SubTerrainBaseCfg(function=StepFieldTerrain(rsegen.load("rubble.yaml")), proportion=0.3)}
"""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING, Protocol

import numpy as np

from rsegen.errors import ParameterError, UserError, pip_install
from rsegen.field.stepfield import Array
from rsegen.learning.tile import index_of, tile
from rsegen.params.extras import MESH
from rsegen.recipe.codec import to_json
from rsegen.recipe.recipe import Recipe
from rsegen.recipe.tiles import check_tile

if TYPE_CHECKING:
    from trimesh import Trimesh


class SubTerrain(Protocol):
    """The used part of a SubTerrainBaseCfg: its size in metres; the generator gives it its seed."""

    size: tuple[float, float]


class StepFieldTerrain:
    """The `function` of a SubTerrainBaseCfg: a map of a recipe at a difficulty, amid level ground.

    The map follows from the recipe, the generator's seed and the difficulty alone. mesh: `merged`, the surface
    in few faces; or closed: `watertight`. The surface has one friction, which the TerrainImporter gives it.
    """

    def __init__(self, recipe: Recipe, mesh: str = "merged") -> None:
        check_tile(recipe)
        if not recipe.is_of_one_friction:
            raise ParameterError("level_friction", "a terrain of Isaac Lab has one friction; give only `friction`")
        self.recipe: Recipe = recipe
        self.kind: str = mesh
        content = to_json(recipe).encode() + mesh.encode()
        self.__name__: str = f"{recipe.name}_{hashlib.blake2b(content, digest_size=8).hexdigest()}"
        """Isaac Lab calls what it keeps in its cache after this."""

    def __call__(self, difficulty: float, cfg: SubTerrain) -> tuple[list[Trimesh], Array]:
        """The mesh, from (0, 0) to the sub-terrain's size, and the origin, in metres."""
        try:
            import trimesh
        except ImportError:
            raise UserError(f"trimesh is not installed; {pip_install([MESH.name])}") from None
        ground = tile(self.recipe, difficulty, index_of(getattr(cfg, "seed", None), difficulty), cfg.size)
        vertices, triangles = ground.mesh(self.kind)
        return [trimesh.Trimesh(vertices, triangles, process=False)], np.array(ground.origin)
