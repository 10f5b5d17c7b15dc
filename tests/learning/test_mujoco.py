"""Blocks that change in place are the compiled map, contact by contact."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import rsegen
from rsegen import Random, Recipe
from rsegen.errors import ParameterError
from rsegen.recipe.examples import EXAMPLES

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")
adapter = pytest.importorskip("rsegen.learning.mujoco")

RECIPE = Recipe(
    seed=7,
    chunk_size=6,
    chunks=(1, 2),
    unit_cm=5,
    boundary="none",
    level_friction=(0.2, 0.4, 0.6, 0.8, 0.9),
    level_colours=("#ff0000",),
    obstacles=[Random(levels=6)],
)
RADIUS = 0.03


def _with_ball(spec: Any) -> tuple[Any, Any]:
    """A model with a free ball that has no friction of its own."""
    body = spec.worldbody.add_body(name="ball", pos=[0, 0, 2])
    body.add_freejoint()
    body.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[RADIUS, 0, 0], friction=[0, 0, 0])
    model = spec.compile()
    return model, mujoco.MjData(model)


def _contacts(model: Any, state: Any, x: float, y: float, z: float) -> list[tuple[float, ...]]:
    """Depth, place and friction of each contact of the ball there."""
    state.qpos[:] = [x, y, z, 1, 0, 0, 0]
    mujoco.mj_forward(model, state)
    found = state.contact[: state.ncon]
    return sorted((round(c.dist, 9), *np.round(c.pos, 9).tolist(), round(float(c.friction[0]), 9)) for c in found)


def test_each_cell_of_a_written_map_is_that_of_the_compiled_one() -> None:
    grid, spec = adapter.BlockGrid(RECIPE), mujoco.MjSpec()
    grid.add_to(spec)
    model, state = _with_ball(spec)
    for index, levels in enumerate(rsegen.build_many(RECIPE, range(4))):
        grid.write(model, levels)
        of_its_own = mujoco.MjSpec()
        adapter.add_map(of_its_own, rsegen.compose(RECIPE, index))
        ground = {"type": mujoco.mjtGeom.mjGEOM_PLANE, "size": [0, 0, 1], "friction": [RECIPE.friction, 0.005, 0.0001]}
        of_its_own.worldbody.add_geom(**ground)
        compiled, other = _with_ball(of_its_own)
        for i, j in np.ndindex(*levels.shape):
            x, y = (i - 2.5) * 0.1, (j - 5.5) * 0.1
            for lifted in (-0.001, 0.001):
                at = x, y, levels[i, j] * 0.05 + RADIUS + lifted
                assert _contacts(model, state, *at) == _contacts(compiled, other, *at)
            assert len(_contacts(model, state, x, y, levels[i, j] * 0.05 + RADIUS - 0.001)) == 1


def test_a_ball_rests_on_the_blocks_written_last() -> None:
    grid, spec = adapter.BlockGrid(RECIPE, pos=(1, 2, 0.5)), mujoco.MjSpec()
    grid.add_to(spec)
    model, state = _with_ball(spec)
    for level in (5, 0, 3):
        grid.write(model, np.full(grid.shape, level))
        mujoco.mj_resetData(model, state)
        state.qpos[:3] = [1.05, 2.05, 0.5 + level * 0.05 + 0.1]
        mujoco.mj_step(model, state, 1000)
        assert state.qpos[2] == pytest.approx(0.5 + level * 0.05 + RADIUS, abs=0.001)


def test_arrays_of_many_maps_equal_the_arrays_of_each_map() -> None:
    grid, many = adapter.BlockGrid(RECIPE), rsegen.build_many(RECIPE, range(3))
    for array in (grid.pos, grid.size, grid.rgba, grid.friction):
        assert array(many).shape[:2] == (3, 72)
        assert np.array_equal(array(many)[2], array(many[2]))
    assert grid.rgba(np.ones(grid.shape, dtype=int))[0].tolist() == [1, 0, 0, 1]


def test_a_map_has_no_mass() -> None:
    spec = mujoco.MjSpec()
    body = adapter.add_map(spec, rsegen.compose(RECIPE, 0), pos=(0, 0, 1))
    model = spec.compile()
    assert model.body_mass.sum() == 0
    assert model.body(body.name).pos.tolist() == [0, 0, 1]


def test_values_that_a_grid_cannot_hold_are_refused() -> None:
    with pytest.raises(ParameterError, match="boundary: 'divided' has frames"):
        adapter.BlockGrid(Recipe(seed=1))
    with pytest.raises(ParameterError, match=r"levels: of shape \(3, 3\) for a grid of \(6, 12\)"):
        adapter.BlockGrid(RECIPE).pos(np.zeros((3, 3), dtype=int))
    with pytest.raises(ParameterError, match=r"levels: 6..6 are not all in 0..5, the levels of the recipe"):
        adapter.BlockGrid(RECIPE).pos(np.full((6, 12), 6))


def test_rays_find_every_block_and_hole_of_a_deck() -> None:
    recipe = rsegen.load(EXAMPLES["stairs-and-stones"])
    field, spec = rsegen.build(recipe), mujoco.MjSpec()
    adapter.add_map(spec, rsegen.compose(recipe))
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 1])
    grid = adapter.BlockGrid(recipe, pos=(0, 10, 0))
    grid.add_to(spec)
    model = spec.compile()
    grid.write(model, field.levels)
    state = mujoco.MjData(model)
    mujoco.mj_forward(model, state)
    x, y = (edges[:-1] + field.block_width / 2 for edges in field.edges())
    for at_y in (0, 10):
        tops = np.array([[2 - _ray(model, state, i, j + at_y) for j in y] for i in x])
        assert np.allclose(tops, field.heights, atol=1e-9)
    assert np.unique(field.levels).tolist() == [0, 5, 6, 7, 8, 9, 10]


def _ray(model: Any, state: Any, x: float, y: float) -> float:
    """The way down to the first geom from a height of 2 m."""
    hit = np.zeros(1, dtype=np.int32)
    return float(mujoco.mj_ray(model, state, np.array([x, y, 2.0]), np.array([0, 0, -1.0]), None, 1, -1, hit, None))
