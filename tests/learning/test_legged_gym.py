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


def sampled(terrain: StepFieldTerrain, points: Array) -> Array:
    """Height of the sample at each place in the world, metres."""
    cells = ((points + terrain.cfg.border_size) / terrain.cfg.horizontal_scale).astype(int)
    found = terrain.heightsamples.reshape(terrain.tot_rows, terrain.tot_cols)[cells[:, 0], cells[:, 1]]
    return np.asarray(found * terrain.cfg.vertical_scale)


def measured(terrain: StepFieldTerrain, points: Array) -> Array:
    """Heights at places as a task measures them (`_get_heights`): the lowest of a sample and the next on each axis."""
    scale = terrain.cfg.horizontal_scale
    return np.asarray(np.min([sampled(terrain, points + ahead) for ahead in ((0, 0), (scale, 0), (0, scale))], axis=0))


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
def test_a_robot_measures_the_lowest_of_the_mesh_below_it_and_a_sample_ahead(surface: str, samples: int) -> None:
    terrain = partial(StepFieldTerrain, COURSE, samples=samples, surface=surface)(cfg(), 64)
    scale, extent = terrain.cfg.horizontal_scale, np.array(COURSE.field.extent)
    points = np.random.default_rng(1).uniform([0, 0], extent - scale, (400, 2)) - terrain.cfg.border_size

    # Isaac Gym puts the mesh so far from the origin of the world.
    vertices = terrain.vertices - np.array([terrain.cfg.border_size, terrain.cfg.border_size, 0])
    below, *ahead = (
        seen_from_above(vertices, terrain.triangles, points + step) for step in ((0, 0), (scale, 0), (0, scale))
    )
    assert np.ptp(below) > 0.19
    assert below == pytest.approx(sampled(terrain, points), abs=1e-5)
    heights = measured(terrain, points)
    assert heights == pytest.approx(np.min([below, *ahead], axis=0), abs=1e-5)
    assert terrain.vertices.dtype == np.float32
    assert terrain.triangles.dtype == np.uint32


@pytest.mark.parametrize(("samples", "share"), [(1, 0.58), (10, 0.08)])
def test_with_more_samples_a_robot_seldom_measures_a_lower_block_ahead(samples: int, share: float) -> None:
    rubble = rsegen.Recipe(seed=7, chunk_size=20, unit_cm=5, boundary="none", obstacles=[rsegen.Random(levels=6)])
    course = rsegen.Terrain(recipes=[rubble], rows=2, columns=3, difficulty=(1, 1), border=0)
    terrain = StepFieldTerrain(course, cfg(), 64, samples=samples)
    points = np.random.default_rng(1).uniform([0, 0], np.array(course.field.extent) - 0.1, (20_000, 2))
    assert (measured(terrain, points) < sampled(terrain, points)).mean() == pytest.approx(share, abs=0.01)


def test_robots_start_above_the_blocks_of_their_tile() -> None:
    terrain = StepFieldTerrain(COURSE, cfg(), 64, spawn_radius=0.3)
    assert terrain.env_origins.shape == (3, 4, 3)
    for row, column in np.ndindex(3, 4):
        x, y, z = terrain.env_origins[row, column]
        steps = np.linspace(-0.299, 0.299, 31)
        around = np.stack(np.meshgrid(x + steps, y + steps), axis=-1).reshape(-1, 2)
        assert z == pytest.approx(sampled(terrain, around).max())
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
