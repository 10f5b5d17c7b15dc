"""A terrain in place of legged_gym's: what its tasks read of it, held against the mesh that Isaac Gym gets."""

from __future__ import annotations

from functools import partial
from types import SimpleNamespace
from typing import Any

import mujoco
import numpy as np
import pytest

import rsegen
from rsegen.errors import ParameterError, UnknownName
from rsegen.field.stepfield import Array
from rsegen.learning.legged_gym import StepFieldTerrain

LEGS: dict[str, Any] = {"seed": 7, "chunk_size": 8, "unit_cm": 4, "boundary": "none"}
RUBBLE = rsegen.Recipe(name="rubble", **LEGS, obstacles=[rsegen.Random(levels=6)])
PIT = rsegen.Recipe(name="pit", ground_level=5, **LEGS, obstacles=[rsegen.Pit(levels=6, gap_width=2)])
COURSE = rsegen.Terrain(recipes=[RUBBLE, PIT], rows=3, columns=4, border=5, gap=1)


def cfg(**other: Any) -> SimpleNamespace:
    """The terrain of a task as legged_gym has it by default."""
    given = {"mesh_type": "trimesh", "horizontal_scale": 0.1, "vertical_scale": 0.005, "border_size": 25}
    sizes = {"terrain_length": 8.0, "terrain_width": 8.0, "num_rows": 10, "num_cols": 20}
    rest = {"curriculum": True, "static_friction": 1.0, "dynamic_friction": 1.0, "max_init_terrain_level": 5}
    return SimpleNamespace(**given | sizes | rest | other)


def measured(terrain: StepFieldTerrain, points: Array) -> Array:
    """Heights at places in the world, metres, as a task of legged_gym looks them up, but for its minimum with two
    neighbours."""
    cells = ((points + terrain.cfg.border_size) / terrain.cfg.horizontal_scale).astype(int)
    found = terrain.heightsamples.reshape(terrain.tot_rows, terrain.tot_cols)[cells[:, 0], cells[:, 1]]
    return np.asarray(found * terrain.cfg.vertical_scale)


def seen_from_above(vertices: Array, triangles: Any, points: Array) -> list[float]:
    """Heights of a mesh at places, as MuJoCo's rays meet it."""
    spec = mujoco.MjSpec()
    spec.add_mesh(
        name="terrain",
        uservert=vertices.ravel(),
        userface=triangles.astype(np.int32).ravel(),
        inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
    )
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname="terrain")
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    down, geom = np.array([0.0, 0.0, -1.0]), np.zeros(1, np.int32)
    above = [np.array([x, y, 5.0]) for x, y in points]
    return [5 - mujoco.mj_ray(model, data, at, down, None, 1, -1, geom, None) for at in above]


@pytest.mark.parametrize("surface", ["merged", "watertight"])
@pytest.mark.parametrize("samples", [1, 3])
def test_what_a_robot_measures_is_the_mesh_that_it_stands_on(surface: str, samples: int) -> None:
    terrain = partial(StepFieldTerrain, COURSE, samples=samples, surface=surface)(cfg(), 64)
    extent = np.array(COURSE.field.extent)
    points = np.random.default_rng(1).uniform([0, 0], extent, (400, 2)) - terrain.cfg.border_size
    heights = measured(terrain, points)
    assert np.ptp(heights) > 0.19

    # Isaac Gym puts the mesh so far from the origin of the world.
    corner = np.array([terrain.cfg.border_size, terrain.cfg.border_size, 0])
    assert seen_from_above(terrain.vertices - corner, terrain.triangles, points) == pytest.approx(heights, abs=1e-5)
    assert terrain.vertices.dtype == np.float32
    assert terrain.triangles.dtype == np.uint32


def test_robots_start_above_the_blocks_of_their_tile() -> None:
    terrain = StepFieldTerrain(COURSE, cfg(), 64, spawn_radius=0.3)
    assert terrain.env_origins.shape == (3, 4, 3)
    for row, column in np.ndindex(3, 4):
        x, y, z = terrain.env_origins[row, column]
        steps = np.linspace(-0.299, 0.299, 31)
        around = np.stack(np.meshgrid(x + steps, y + steps), axis=-1).reshape(-1, 2)
        assert z == pytest.approx(measured(terrain, around).max())
    # The first tile's corner is the origin of the world, and robots of row 0 are on level ground.
    assert terrain.env_origins[0, 0] == pytest.approx([0.4, 0.4, 0.2])
    assert np.diff(terrain.env_origins[:, 0, 0]) == pytest.approx([0.9, 0.9])
    assert terrain.env_origins[2, :, 2].min() > 0.2 - 1e-9


def test_the_task_is_told_what_the_terrain_decides() -> None:
    own = cfg()
    terrain = StepFieldTerrain(COURSE, own, 64, samples=2)
    assert (own.num_rows, own.num_cols, own.max_init_terrain_level) == (3, 4, 2)
    assert (own.horizontal_scale, own.vertical_scale, own.border_size) == pytest.approx((0.05, 0.04, 0.5))
    assert (terrain.env_length, terrain.env_width) == pytest.approx((0.8, 0.8))
    assert (terrain.tot_rows, terrain.tot_cols) == (2 * (3 * 8 + 2 + 10), 2 * (4 * 8 + 3 + 10))
    assert own.static_friction == own.dynamic_friction == RUBBLE.friction


def test_what_it_cannot_be_is_refused() -> None:
    with pytest.raises(ParameterError, match="mesh_type: 'heightfield' has no vertical sides; use 'trimesh'"):
        StepFieldTerrain(COURSE, cfg(mesh_type="heightfield"), 64)
    with pytest.raises(UnknownName, match="surface"):
        StepFieldTerrain(COURSE, cfg(), 64, surface="boxes")
    slippery = rsegen.Terrain(
        recipes=rsegen.Recipe(level_friction=(0.5, 0.7), **LEGS, obstacles=[rsegen.Random(levels=3)]), rows=2, columns=1
    )
    with pytest.raises(ParameterError, match="level_friction: a terrain of Isaac Gym has one friction"):
        StepFieldTerrain(slippery, cfg(), 64)
