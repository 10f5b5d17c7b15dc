"""Isaac Lab: step fields as sub-terrains of its TerrainGenerator (2.3 and 3.0).

from rsegen.learning.isaaclab import StepFieldTerrainCfg

sub_terrains = {"rubble": StepFieldTerrainCfg(recipe=rsegen.load("rubble.yaml"), proportion=0.3)}

Isaac Lab writes a configuration as a dictionary and reads it again (Hydra), and names what it caches by that
dictionary. So all that decides a tile is a number or a text there: the recipe as JSON, and the number of the tile. A
generator sets the size of its sub-terrains before it makes tiles, and copies the configuration for each, by its method
`copy` (2.3) or by `dataclasses.replace` (3.0). Both make a new one of the fields, whose recipe is JSON already: that is
how a copy is known, and it takes the next number of its sort. What breaks it: a generator that does neither has one
tile for each difficulty.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING, Any

from isaaclab.terrains import SubTerrainBaseCfg
from isaaclab.utils import configclass

from rsegen.errors import ParameterError, UnknownName, UserError
from rsegen.field.stepfield import Array
from rsegen.geometry.mesh_kinds import MESHES
from rsegen.learning import MESH
from rsegen.learning.tile import SPAWN_RADIUS, check_recipe, hashed_index, tile
from rsegen.params.extras import pip_install
from rsegen.recipe.codec import decode, to_json
from rsegen.recipe.recipe import Recipe

if TYPE_CHECKING:
    from trimesh import Trimesh

_MADE = "__made"
"""Attribute of a configuration that is complete; Isaac Lab leaves names that begin so out of its dictionaries."""

_COUNTS: dict[tuple[object, ...], int] = {}
"""Tiles so far of the generator that began last, by the parameters of their sub-terrain."""


def step_field(difficulty: float, cfg: StepFieldTerrainCfg) -> tuple[list[Trimesh], Array]:
    """Return the mesh of a tile, from (0, 0) to the sub-terrain's size, and the origin, in metres."""
    try:
        import trimesh
    except ImportError:
        raise UserError(f"trimesh is not installed; {pip_install([MESH.name])}") from None
    index = hashed_index(getattr(cfg, "seed", None), difficulty, cfg.tile)
    ground = tile(_recipe(cfg.recipe), difficulty, index, cfg.size)
    vertices, triangles = ground.mesh(cfg.mesh)
    return [trimesh.Trimesh(vertices, triangles, process=False)], ground.origin_above(cfg.spawn_radius)


@configclass
class _Parameters(SubTerrainBaseCfg):  # type: ignore[misc]  # Isaac Lab has no types for mypy
    function: Callable[..., Any] = step_field
    recipe: Any = None
    mesh: str = "merged"
    spawn_radius: float = 1.0
    tile: int = 0


class StepFieldTerrainCfg(_Parameters):
    """A map of a recipe at a difficulty, amid level ground; it follows from the seed, the difficulty and the tile.

    recipe: a Recipe, kept as JSON; mesh: `merged`, the surface in few faces; or closed: `watertight`.
    spawn_radius: metres along x and y from the middle of a tile, above whose highest block its origin is: a reset that
    spreads robots this far, their size included, puts none into a block. tile: counted by the generator.
    The surface of a terrain has one friction, which the TerrainImporter gives it.
    """

    def __post_init__(self) -> None:
        is_copy = isinstance(self.recipe, str)
        if not is_copy:
            check_recipe(self.recipe)
            self.recipe = to_json(self.recipe)
        if not _recipe(self.recipe).is_of_one_friction:
            problem = "a terrain of Isaac Lab is one mesh with one friction; set only `friction`"
            raise ParameterError("level_friction", problem)
        if self.mesh not in MESHES:
            raise UnknownName.among("mesh", "mesh", self.mesh, MESHES)
        SPAWN_RADIUS.check("spawn_radius", self.spawn_radius)
        super().__post_init__()
        if is_copy and self._sort in _COUNTS:  # a generator's copy, which it makes for one tile
            self.tile = _COUNTS[self._sort]
            _COUNTS[self._sort] += 1
        self.__dict__[_MADE] = True

    def __setattr__(self, name: str, value: object) -> None:
        super().__setattr__(name, value)
        if name == "size" and _MADE in self.__dict__:  # a generator begins
            self.tile = _COUNTS[self._sort] = 0

    @property
    def _sort(self) -> tuple[object, ...]:
        """Key of the sub-terrains whose tiles are counted together."""
        return self.recipe, self.mesh, self.spawn_radius, self.proportion, tuple(self.size)


@cache
def _recipe(text: str) -> Recipe:
    return decode(json.loads(text))
