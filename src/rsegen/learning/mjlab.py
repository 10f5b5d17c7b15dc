"""mjlab: step fields as sub-terrains of its TerrainGenerator (1.6).

from rsegen.learning.mjlab import StepFieldTerrainCfg

sub_terrains = {"rubble": StepFieldTerrainCfg(recipe=rsegen.load("rubble.yaml"), proportion=0.3)}
"""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from mjlab.terrains.terrain_generator import SubTerrainCfg, TerrainGeometry, TerrainOutput

from rsegen.exporters.formats.parts import Column
from rsegen.exporters.scene import Scene
from rsegen.learning.blocks import GROUND_COLOUR
from rsegen.learning.mujoco import add_box
from rsegen.learning.tile import tile
from rsegen.recipe.recipe import Recipe
from rsegen.recipe.tiles import check_tile


@dataclass(kw_only=True)
class StepFieldTerrainCfg(SubTerrainCfg):  # type: ignore[misc]  # mjlab has no types for mypy
    """A map of a recipe at a difficulty, amid level ground; the generator's random numbers choose the map."""

    recipe: Recipe

    def __post_init__(self) -> None:
        check_tile(self.recipe)

    def function(self, difficulty: float, spec: mujoco.MjSpec, rng: np.random.Generator) -> TerrainOutput:
        """Boxes of the body `terrain`, from (0, 0) to the sub-terrain's size, and the origin, in metres."""
        ground, body = tile(self.recipe, difficulty, int(rng.integers(2**63)), self.size), spec.body("terrain")
        look = Scene(recipe=self.recipe, index=0, field=ground.raised)
        geometries = [
            TerrainGeometry(geom=add_box(body, column, look.friction_of(column.material)), color=_colour(look, column))
            for column in ground.columns()
        ]
        return TerrainOutput(origin=np.array(ground.origin), geometries=geometries)


def _colour(look: Scene, column: Column) -> tuple[float, float, float, float]:
    """Return the colour of a column's level, with opacity."""
    return (*(look.colour(column.material) if column.material else GROUND_COLOUR), 1.0)
