"""A field as the floor of MuJoCo Playground's Go1: its feet are on blocks of two maps, and a policy learns a step."""

from __future__ import annotations

from copy import copy
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

import rsegen
from rsegen.errors import ParameterError, UserError
from tests.support.late_import import LateImport

jax = LateImport("jax", reason="jax is not installed: Playground brings it")
optax = LateImport("optax", reason="optax is not installed: Playground brings it")
adapter = LateImport("rsegen.learning.playground", reason="MuJoCo is not installed")

RECIPE = rsegen.Recipe(seed=7, chunk_size=20, unit_cm=4, boundary="none", obstacles=[rsegen.Random(levels=5)])
_CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], np.float32) / 10
_FACE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attributes", "<u2")])
_FACES = np.zeros(4, _FACE)
_FACES["corners"] = _CORNERS[[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]]
TETRAHEDRON = bytes(80) + np.uint32(4).tobytes() + _FACES.tobytes()
"""An STL file."""

PLANE = """<mujoco><worldbody><geom name="floor" type="plane" size="0 0 1"/></worldbody></mujoco>"""


def from_above(model: Any, x: Any, y: Any) -> np.ndarray:
    """Heights of the floor as MuJoCo's rays meet it, (n_x, n_y), metres."""
    data, geom, down = mujoco.MjData(model), np.zeros(1, np.int32), np.array([0.0, 0.0, -1.0])
    mujoco.mj_forward(model, data)
    above = [[np.array([own, other, 3.0]) for other in y] for own in x]
    return np.array(
        [[3 - mujoco.mj_ray(model, data, at, down, None, 1, -1, geom, None) for at in row] for row in above]
    )


@pytest.mark.parametrize(("border", "ground_level"), [(0, 0), (3, 2)])
def test_the_floor_is_the_field_below_the_highest_block_near_the_middle(border: int, ground_level: int) -> None:
    recipe = replace(RECIPE, ground_level=ground_level)
    floor = adapter.Floor(recipe, border=border, spawn_radius=0.3)
    model = mujoco.MjModel.from_xml_string(floor.scene(PLANE))
    levels = np.full((20 + 2 * border, 20 + 2 * border), ground_level)
    levels[border : border + 20, border : border + 20] = rsegen.build(recipe).levels
    field, first = floor.field(rsegen.build(recipe).levels), model.hfield_data.copy()
    assert np.array_equal(field.levels, levels)
    near = field.heights[border + 6 : border + 14, border + 6 : border + 14]  # with those that slope into 0.3 m
    assert len(np.unique(near)) == 5
    assert from_above(model, *field.middles()) == pytest.approx(field.heights - near.max(), abs=1e-6)
    assert model.geom("floor").friction[0] == RECIPE.friction
    # Maps of worlds are written into the compiled model.
    others = rsegen.build_many(recipe, [3, 4])
    for levels, data, z in zip(others, *floor.arrays(others), strict=True):
        model.hfield_data[:], model.geom("floor").pos[2] = data, z
        field = floor.field(levels)
        expected = field.heights - floor.top(field)
        assert from_above(model, *field.middles()) == pytest.approx(expected, abs=1e-6)
        assert z == pytest.approx(expected.min(), abs=1e-6)
    # The floor of a scene with a height field of its own is replaced too.
    again = mujoco.MjModel.from_xml_string(floor.scene(floor.scene(PLANE)))
    assert again.nhfield == 1
    assert np.array_equal(again.hfield_data, first)


def test_no_slope_reaches_above_the_top_near_the_middle() -> None:
    floor = adapter.Floor(RECIPE, spawn_radius=0.1)
    model = mujoco.MjModel.from_xml_string(floor.scene(PLANE))
    maps = rsegen.build_many(RECIPE, range(10))
    along = np.linspace(-0.1, 0.1, 21) + 1e-4
    for data, z in zip(*floor.arrays(maps), strict=True):
        model.hfield_data[:], model.geom("floor").pos[2] = data, z
        assert from_above(model, along[:-1], along[:-1]).max() <= 1e-6


def depths_in_mujoco(model: Any, qpos: Any, hfield: Any, z: Any) -> dict[str, tuple[float, Any]]:
    """Depth of each foot in the floor of a world, metres, and where it touches it, as MuJoCo finds it."""
    own = copy(model)
    own.hfield_data[:], own.geom("floor").pos[2] = hfield, z
    data = mujoco.MjData(own)
    data.qpos[:] = qpos
    mujoco.mj_forward(own, data)
    floor = own.geom("floor").id
    depths: dict[str, tuple[float, Any]] = {}
    for contact in data.contact:
        assert floor in contact.geom
        foot = own.geom(int(contact.geom.sum() - floor)).name
        if contact.dist < 0 and -contact.dist > depths.get(foot, (0.0, None))[0]:
            depths[foot] = -contact.dist, contact.pos.copy()
    return depths


def test_what_cannot_be_a_floor_is_refused() -> None:
    with pytest.raises(UserError, match="0 geoms are named floor"):
        adapter.Floor(RECIPE).scene("<mujoco><asset/></mujoco>")
    rough: dict[str, Any] = {"seed": 7, "chunk_size": 4, "obstacles": [rsegen.Random(levels=3)]}
    with pytest.raises(ParameterError, match="boundary: a height field has one friction and no frames"):
        adapter.Floor(rsegen.Recipe(**rough, boundary="outer"))
    with pytest.raises(ParameterError, match="level_friction: a height field has one friction"):
        adapter.Floor(rsegen.Recipe(**rough, boundary="none", level_friction=(0.5, 0.7)))


def test_each_world_has_a_map_by_its_key() -> None:
    keys = jax.random.split(jax.random.PRNGKey(3), 50)
    several = adapter.Floor(replace(RECIPE, maps=3, first_map=5))
    assert set(several.indices(keys)) == {5, 6, 7}
    assert several.indices(keys[10:20]) == several.indices(keys)[10:20]
    assert len(set(adapter.Floor(RECIPE).indices(keys))) == 50


@pytest.mark.long(reason="MuJoCo Playground: compiling its environment takes minutes")
@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")  # its own
def test_go1_stands_on_a_map_of_each_world_and_learns_a_step(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    pytest.importorskip("mujoco_playground", reason="MuJoCo Playground is not installed: pip install playground")
    from mujoco_playground import wrapper
    from mujoco_playground._src.locomotion.go1 import base, go1_constants, joystick

    jnp, worlds, own = jax.numpy, 2, base.get_assets
    # What is seen of Go1, and touches nothing, Playground downloads from MuJoCo Menagerie.
    looks = {f"{name}.stl": TETRAHEDRON for name in ("trunk", "hip", "thigh", "thigh_mirror", "calf")}
    monkeypatch.setattr(base, "get_assets", lambda: looks | own())
    floor = adapter.Floor(RECIPE, border=4, samples=2, spawn_radius=0.9)
    scene = floor.write(go1_constants.FEET_ONLY_FLAT_TERRAIN_XML, tmp_path / "rubble.xml")
    monkeypatch.setattr(go1_constants, "FEET_ONLY_FLAT_TERRAIN_XML", scene)
    # Penalties would leave a policy that knows nothing without any reward, as Playground has none below 0.
    scales = joystick.default_config().reward_config.scales
    without = {f"reward_config.scales.{name}": 0.0 for name, scale in scales.items() if scale < 0}
    bare = joystick.Joystick("flat_terrain", config_overrides={"impl": "jax", **without})
    keys = jax.random.split(jax.random.PRNGKey(3), worlds)
    env = wrapper.wrap_for_brax_training(bare, randomization_fn=partial(floor.randomize, rng=keys))
    step, state = jax.jit(env.step), jax.jit(env.reset)(keys)
    for _ in range(25):  # they fall, and stand
        state = step(state, jnp.zeros((worlds, 12)))

    levels = rsegen.build_many(RECIPE, floor.indices(keys))
    assert not np.array_equal(*levels)
    tops = np.array([floor.top(floor.field(levels_of_world)) for levels_of_world in levels])
    ground = rsegen.Ground(RECIPE, jnp.asarray(levels))
    sensors = [bare.mj_model.sensor_adr[sensor] for sensor in bare._feet_floor_found_sensor]
    touches = np.asarray(state.data.sensordata[:, sensors]) > 0
    assert touches.sum() >= 4
    stood_on = set()
    for world, (hfield, z) in enumerate(zip(*floor.arrays(levels), strict=True)):
        depths = depths_in_mujoco(bare.mj_model, np.asarray(state.data.qpos[world]), hfield, z)
        for foot, touch in zip(go1_constants.FEET_GEOMS, touches[world], strict=True):
            assert touch == (foot in depths)
        for depth, place in depths.values():
            assert depth < 0.008
            stood_on.add(round(float(place[2] + tops[world]), 2))
    assert len(stood_on) >= 2

    pattern, rows = jnp.asarray(rsegen.scan_points((0.8, 0.6), 0.2)), []

    def seen(state: Any) -> Any:
        place = state.data.qpos[:, :3] + jnp.stack([0 * tops, 0 * tops, tops], axis=1)
        scan = ground.scan(pattern, jnp.concatenate([place, 0 * place[:, :1]], axis=1))
        return jnp.concatenate([state.obs["state"], scan], axis=1)

    weights = 0.01 * jax.random.normal(keys[0], (seen(state).shape[1], 12))
    for key in jax.random.split(keys[1], 10):
        observed = seen(state)
        taken = observed @ weights + 0.3 * jax.random.normal(key, (worlds, 12))
        state = step(state, taken)
        rows.append((observed, taken, state.reward))
    observed, taken, rewards = map(jnp.stack, zip(*rows, strict=True))
    assert float(rewards.std()) > 0
    assert float(observed[0, :, -pattern.shape[0] :].std()) > 0.02
    advantage = (rewards - rewards.mean()) / rewards.std()

    def loss(weights: Any) -> Any:
        return (((taken - observed @ weights) ** 2).sum(axis=2) * advantage).mean()

    optimizer = optax.adam(1e-4)
    updates, _ = optimizer.update(jax.grad(loss)(weights), optimizer.init(weights))
    after = optax.apply_updates(weights, updates)
    assert bool((after != weights).all())
    assert float(loss(after)) < float(loss(weights))
