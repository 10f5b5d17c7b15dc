"""mjlab: step fields as sub-terrains of its TerrainGenerator (1.6).

from rsegen.learning.mjlab import StepFieldTerrainCfg

sub_terrains = {"rubble": StepFieldTerrainCfg(recipe=rsegen.load("rubble.yaml"), proportion=0.3)}

Boxes are exact, but mujoco_warp lists every pair of geoms, so a terrain has a budget of them. A height field is one
geom for a tile of any size; it slopes from the edge of a block to the next sample.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from mjlab.terrains.terrain_generator import FlatPatchSamplingCfg, SubTerrainCfg, TerrainGeometry, TerrainOutput

from rsegen.datasets.difficulty_tiles import kind_of_column
from rsegen.errors import ParameterError, TooLarge, UnknownName
from rsegen.field.stepfield import Array
from rsegen.learning.blocks import GROUND_COLOUR
from rsegen.learning.ground import friction_by_level
from rsegen.learning.mujoco import add_box, add_height_field
from rsegen.learning.tile import SAMPLES, SPAWN_RADIUS, Tile, check_recipe, slope_length, tile
from rsegen.recipe.recipe import Recipe
from rsegen.scene.contact import CONTACT, Contact
from rsegen.scene.scene import Scene

_SHAPES = ("boxes", "hfield")

_PAIR_BYTES = 70
"""Bytes at the peak of mujoco_warp's `put_model` per squared number of geoms, measured with 2,000 and 4,000 (4.0)."""


@dataclass(kw_only=True)
class StepFieldTerrainCfg(SubTerrainCfg):  # type: ignore[misc]  # mjlab has no types for mypy
    """A map of a recipe at a difficulty, amid level ground; the generator's random numbers choose the map.

    shape: `boxes`, or `hfield`, with `samples` along each side of a block, for large terrains.
    most_boxes: of the whole terrain; 4,000 take 1.1 GB while mujoco_warp loads them, and twice as many four times that.
    spawn_radius: metres along x and y from the middle of a tile, above whose highest block its origin is: a reset that
    spreads robots this far, their size included, puts none into a block.
    contact: its priority is above the one of mjlab's robots, so the recipe's friction acts; with `Contact(priority=-1)`
    the friction of the feet acts, which mjlab's events draw.
    """

    recipe: Recipe
    shape: str = "boxes"
    samples: int = 4
    most_boxes: int = 4000
    spawn_radius: float = 1.0
    contact: Contact = CONTACT

    def __post_init__(self) -> None:
        check_recipe(self.recipe)
        if self.shape not in _SHAPES:
            raise UnknownName.among("shape", "shape", self.shape, _SHAPES)
        SAMPLES.check("samples", self.samples)
        SPAWN_RADIUS.check("spawn_radius", self.spawn_radius)
        if self.shape == "hfield" and not self.recipe.is_of_one_friction:
            raise ParameterError("level_friction", "a height field has one friction; set only `friction`, or use boxes")

    def function(self, difficulty: float, spec: mujoco.MjSpec, rng: np.random.Generator) -> TerrainOutput:
        """Geoms of the body `terrain`, from (0, 0) to the sub-terrain's size, the origin and level places, metres."""
        ground = tile(self.recipe, difficulty, int(rng.integers(2**63)), self.size)
        # Around a block of a height field its slope counts too: origins and level places keep that much more distance.
        slope = slope_length(self.recipe.block_width_cm / 100, self.samples) if self.shape == "hfield" else 0.0
        sampling = (self.flat_patch_sampling or {}).items()
        patches = {name: _patches(ground, request, slope, rng) for name, request in sampling}
        if self.shape == "boxes":
            geometries = self._boxes(spec, ground)
        else:
            name, heights = f"{self.recipe.name}_{len(spec.hfields)}", ground.samples(self.samples)
            attributes = self.contact.attributes(self.recipe.friction)
            field, geom = add_height_field(spec, spec.body("terrain"), name, heights, ground.size, attributes)
            geometries = [TerrainGeometry(geom=geom, hfield=field, color=(*GROUND_COLOUR, 1.0))]
        return TerrainOutput(
            origin=ground.origin_above(self.spawn_radius + slope), geometries=geometries, flat_patches=patches or None
        )

    def _boxes(self, spec: mujoco.MjSpec, ground: Tile) -> list[TerrainGeometry]:
        look = Scene(recipe=self.recipe, index=0, field=ground.raised)
        body, columns = spec.body("terrain"), list(ground.columns())
        count = len(body.geoms) + len(columns)  # with the boxes of the tiles before
        if count > self.most_boxes:
            peak = f"{_PAIR_BYTES * count**2 / 1e9:.1f} GB in mujoco_warp"
            problem = f"more than {self.most_boxes:,} boxes, the budget of the terrain; {count:,} need {peak}"
            raise TooLarge(f"most_boxes: {problem}; use shape='hfield', fewer tiles, or a larger most_boxes")
        # Frames are blocks too, and may be higher than all others.
        friction, geometries = friction_by_level(self.recipe, max(column.material for column in columns)), []
        for column in columns:
            colour = look.colour(column.material) if column.material else GROUND_COLOUR
            geom = add_box(body, column, self.contact.attributes(float(friction[column.material])))
            geometries.append(TerrainGeometry(geom=geom, color=(*colour, 1.0)))
        return geometries


def columns(recipes: Sequence[Recipe], count: int, **values: Any) -> dict[str, StepFieldTerrainCfg]:
    """Return a sub-terrain for each of `count` columns of a curriculum: mjlab makes as many, whatever `num_cols` is.

    All recipes have equally many neighbouring columns, or one more; values: of each sub-terrain. ParameterError if
    there are fewer columns than recipes.
    """
    if not 0 < len(recipes) <= count:
        raise ParameterError("count", f"{count} columns for {len(recipes)} recipes; use one for each, or more")
    chosen = [recipes[kind_of_column(column, count, len(recipes))] for column in range(count)]
    return {
        f"{recipe.name}_{column}": StepFieldTerrainCfg(recipe=recipe, proportion=1.0 / count, **values)
        for column, recipe in enumerate(chosen)
    }


def _patches(ground: Tile, request: FlatPatchSamplingCfg, slope: float, rng: np.random.Generator) -> Array:
    """Return level places on a tile, (patches, 3): fewer where there are fewer, and mjlab fills up with the origin."""
    places = ground.level_squares(2 * (request.patch_radius + slope), request.max_height_diff)
    for axis, (low, high) in enumerate((request.x_range, request.y_range, request.z_range)):
        places = places[(places[:, axis] >= low) & (places[:, axis] <= high)]
    return places[np.argsort(rng.random(len(places)))[: request.num_patches]]
