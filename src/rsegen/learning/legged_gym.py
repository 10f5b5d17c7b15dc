"""legged_gym and what grew out of it: a Terrain in place of theirs, on which robots start and move between rows.

    from functools import partial
    from legged_gym.envs.base import legged_robot
    from rsegen.learning.legged_gym import StepFieldTerrain

    legged_robot.Terrain = partial(StepFieldTerrain, rsegen.Terrain(recipes=[rubble, ridge], border=50))

A task is made and trained as before, with `mesh_type = "trimesh"`. Isaac Gym gets the mesh of the blocks, whose sides
are vertical, and the task the same heights as whole units. legged_gym measures the lowest of a sample and the next ones
along x and y (`_get_heights`), so up to a sample before a lower block a robot measures that one: with one sample for
each block often, with more `samples` seldom. Rows, columns, scales, the border and friction are those of the terrain:
they are written into the task's `cfg.terrain`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from rsegen.errors import ParameterError, UnknownName, refuse_other
from rsegen.field.stepfield import Levels
from rsegen.geometry.mesh_kinds import MESHES
from rsegen.learning.ground import unframed
from rsegen.learning.terrain import Terrain
from rsegen.learning.tile import SAMPLES, SPAWN_RADIUS, Tile, highest_near


class StepFieldTerrain:
    """A terrain as legged_gym's tasks read it. x and y are metres from the corner of the field, z from its floor.

    terrain: has one friction; cfg: `cfg.terrain` of a task, which is given the terrain's figures; num_robots: of the
    task; samples: of heights along each side of a block; spawn_radius: metres along x and y from the middle of a tile,
    above whose highest block its origin is; surface: `merged`, in few faces, or `watertight`

    env_origins: (rows, columns, 3), the middles of tiles, metres from the corner of the first tile; heightsamples:
    (n_x * samples, n_y * samples), int16, units; vertices: (n, 3), float32; triangles: (m, 3), uint32
    """

    def __init__(
        self,
        terrain: Terrain,
        cfg: Any,
        num_robots: int,
        *,
        samples: int = 1,
        spawn_radius: float = 1.0,
        surface: str = "merged",
    ) -> None:
        refuse_other("terrain", terrain, Terrain)
        samples, radius = SAMPLES.check("samples", samples), SPAWN_RADIUS.check("spawn_radius", spawn_radius)
        if surface not in MESHES:
            raise UnknownName.among("surface", "mesh", surface, MESHES)
        if cfg.mesh_type != "trimesh":
            raise ParameterError("mesh_type", f"{cfg.mesh_type!r} has no vertical sides; use 'trimesh'")
        if not terrain.recipe.is_of_one_friction:
            raise ParameterError("level_friction", "a terrain of Isaac Gym has one friction; set only `friction`")
        field, width = terrain.field, terrain.field.block_width
        self.cfg, self.num_robots, self.type = cfg, num_robots, "trimesh"
        self.env_length, self.env_width = terrain.tile_size
        self.border = terrain.border * samples
        self._write(terrain, width / samples)
        self.heightsamples: Levels = np.repeat(np.repeat(field.levels, samples, axis=0), samples, axis=1)
        self.height_field_raw = self.heightsamples
        self.tot_rows, self.tot_cols = self.heightsamples.shape
        # The mesh begins at the corner of the field; as in tile.py, its field is raised by a level and lowered.
        half = np.array([*field.extent, 0.0]) / 2
        raised = unframed(field.levels + np.int16(1), width, field.unit)
        vertices, triangles = Tile(raised=raised, ground=0, size=field.extent, origin=half).mesh(surface)
        self.vertices, self.triangles = vertices.astype(np.float32), triangles.astype(np.uint32)
        # legged_gym moves the mesh by -border_size, so origins count from the corner of the first tile.
        self.env_origins = terrain.origins + half
        for origin in self.env_origins.reshape(-1, 3):
            origin[2] = max(origin[2], highest_near(field, origin[:2], radius))
        self.env_origins -= [cfg.border_size, cfg.border_size, 0]

    def _write(self, terrain: Terrain, scale: float) -> None:
        """Write into the task's configuration what the terrain decides."""
        cfg = self.cfg
        cfg.num_rows, cfg.num_cols = terrain.rows, terrain.columns
        cfg.num_sub_terrains = terrain.rows * terrain.columns
        cfg.max_init_terrain_level = min(cfg.max_init_terrain_level, terrain.rows - 1)
        cfg.terrain_length, cfg.terrain_width = terrain.tile_size
        cfg.horizontal_scale, cfg.vertical_scale = scale, terrain.field.unit
        cfg.border_size = terrain.border * terrain.field.block_width
        cfg.static_friction = cfg.dynamic_friction = terrain.recipe.friction
