"""An environment has a new field at each reset, above which its robot starts: MuJoCo's contacts judge."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rsegen
from rsegen import Random, Recipe
from rsegen.errors import ParameterError, UserError

gymnasium = pytest.importorskip("gymnasium", reason="Gymnasium is not installed")
mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")
from rsegen.learning.gymnasium import NewFieldAtReset  # noqa: E402  # it needs both
from rsegen.learning.mujoco import BlockGrid, geom_bounds  # noqa: E402

RECIPE = Recipe(
    seed=7,
    chunk_size=20,
    unit_cm=5,
    boundary="none",
    level_friction=(0.2, 0.4, 0.6, 0.8, 0.9),
    obstacles=[Random(levels=6)],
)
GRID = BlockGrid(RECIPE)
ASSETS = Path(gymnasium.__file__).parent / "envs" / "mujoco" / "assets"
RADIUS = 0.03

pytestmark = pytest.mark.filterwarnings("ignore:compiler attribute 'settotalmass'")  # of Gymnasium's own file


def _made(robot: str, file: str, grid: BlockGrid, folder: Path) -> Any:
    spec = mujoco.MjSpec.from_file(str(ASSETS / file))
    grid.add_to(spec)
    spec.compile()
    path = folder / file
    path.write_text(spec.to_xml(), "utf-8")
    return gymnasium.make(robot, xml_file=str(path))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("robot", "file", "height", "rise"),
    [
        ("Humanoid-v5", "humanoid.xml", 2, 0.0),
        ("Ant-v5", "ant.xml", 2, 0.5),  # it starts high above the ground
        ("HalfCheetah-v5", "half_cheetah.xml", 1, 0.0),
        ("Walker2d-v5", "walker2d_v5.xml", 1, 0.0),
        ("Hopper-v5", "hopper.xml", 1, 0.0),
    ],
)
def test_no_geom_of_a_robot_starts_inside_a_block(
    robot: str, file: str, height: int, rise: float, tmp_path: Path
) -> None:
    grid = BlockGrid(RECIPE, pos=(0, 0, rise))
    bare = _made(robot, file, grid, tmp_path)
    env, model, data = NewFieldAtReset(bare, grid), bare.unwrapped.model, bare.unwrapped.data
    first = model.geom(grid.names[0]).id

    def touched() -> np.ndarray:
        own = data.contact.geom
        return ((own >= first) & (own < first + len(grid.names))).any(axis=1)  # type: ignore[no-any-return]

    def depth() -> float:
        mujoco.mj_forward(model, data)
        return float(-data.contact.dist[touched()].min(initial=0.0))

    raised, before, landed = [], [], 0
    for reset in range(100):
        observation, _ = env.reset(seed=3 if reset == 0 else None)
        assert depth() <= 0
        raised.append(data.qpos[height])
        # The first numbers of an observation are positions, without those along the ground.
        assert observation[0] == pytest.approx(data.qpos[height])
        if reset < 5:
            mujoco.mj_step(model, data, round(1 / model.opt.timestep))
            landed += int(touched().sum())
        bare.reset()
        before.append(depth())
    assert landed > 0
    # Without the wrapper a robot starts on the ground, so nearly every field is in its way.
    assert np.mean(np.array(before) > 0.01) > 0.8
    assert max(raised) - min(raised) > 0.02


def test_bounds_of_geoms_are_those_of_their_surface() -> None:
    spec, shapes = mujoco.MjSpec(), mujoco.mjtGeom
    sizes = {
        shapes.mjGEOM_SPHERE: [0.3, 0, 0],
        shapes.mjGEOM_CAPSULE: [0.1, 0.4, 0],
        shapes.mjGEOM_CYLINDER: [0.2, 0.3, 0],
        shapes.mjGEOM_ELLIPSOID: [0.1, 0.2, 0.3],
        shapes.mjGEOM_BOX: [0.1, 0.2, 0.3],
    }
    for shape, size in sizes.items():
        spec.worldbody.add_geom(type=shape, size=size, pos=[1, 2, 3], quat=[0.5, -0.3, 0.7, 0.2])
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    low, high = geom_bounds(model, data, np.arange(model.ngeom))
    # A tangent plane is where a ray along an axis from far away first hits: the nearest of many rays comes close.
    for geom in range(model.ngeom):
        alone = np.zeros(6, dtype=np.uint8)
        alone[0] = 1
        model.geom_group[:] = 1
        model.geom_group[geom] = 0
        for axis in range(3):
            across = [other for other in range(3) if other != axis]
            grid = np.meshgrid(*(np.linspace(low[geom, a], high[geom, a], 61) for a in across))
            hits = []
            for u, v in zip(*(part.ravel() for part in grid), strict=True):
                start, way = np.zeros(3), np.zeros(3)
                start[across], start[axis], way[axis] = (u, v), -10, 1
                distance = mujoco.mj_ray(model, data, start, way, alone, 1, -1, np.zeros(1, dtype=np.int32))
                hits += [distance - 10] if distance >= 0 else []
            assert min(hits) == pytest.approx(low[geom, axis], abs=0.01)
            assert min(hits) >= low[geom, axis] - 1e-9


class Dropped(gymnasium.Env):  # type: ignore[misc,name-defined]  # it has no types for mypy
    """A ball that falls; what is seen is its height."""

    def __init__(self, spec: Any) -> None:
        body = spec.worldbody.add_body(name="ball", pos=[0, 0, 2])
        body.add_freejoint()
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[RADIUS, 0, 0])
        self.model = spec.compile()
        self.state = mujoco.MjData(self.model)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        super().reset(seed=seed)
        mujoco.mj_resetData(self.model, self.state)
        self.state.qpos[:3] = [0.05, 0.05, 0.4]
        mujoco.mj_step(self.model, self.state, 1000)
        return self.state.qpos[2] - RADIUS, {"own": 1}


def test_an_environment_has_a_new_field_at_each_reset() -> None:
    spec = mujoco.MjSpec()
    GRID.add_to(spec)
    env = NewFieldAtReset(Dropped(spec), GRID)
    seen = [env.reset(seed=5 if first else None) for first in (True, False, False)]
    again = [env.reset(seed=5 if first else None) for first in (True, False, False)]
    assert len({info["map"] for _, info in seen}) == 3
    assert [info["map"] for _, info in again] == [info["map"] for _, info in seen]
    for height, info in [*seen, env.reset(options={"map": 17})]:
        assert info["own"] == 1
        assert height == pytest.approx(0.05 * rsegen.build(RECIPE, info["map"]).levels[10, 10], abs=0.001)
    assert env.reset(options={"map": 17})[1]["map"] == 17
    assert np.array_equal(env.ground.levels, rsegen.build(RECIPE, 17).levels)
    assert env.reset(seed=5, options={"of": "another"})[1]["map"] == seen[0][1]["map"]


@pytest.mark.parametrize("index", [-1, 1.5, "17", None])
def test_a_map_of_a_reset_is_a_whole_number(index: object) -> None:
    spec = mujoco.MjSpec()
    GRID.add_to(spec)
    with pytest.raises(ParameterError, match=r"^options\['map'\]: "):
        NewFieldAtReset(Dropped(spec), GRID).reset(options={"map": index})


def test_maps_that_are_made_ahead_are_those_of_the_recipe() -> None:
    spec = mujoco.MjSpec()
    grid = BlockGrid(Recipe(seed=7, chunk_size=3, maps=4, first_map=6, boundary="none", obstacles=[Random(levels=6)]))
    grid.add_to(spec)
    env = NewFieldAtReset(Dropped(spec), grid)
    indices = []
    for reset in range(150):
        indices.append(env.reset(seed=1 if reset == 0 else None)[1]["map"])
        assert np.array_equal(env.ground.levels, rsegen.build(grid.recipe, indices[-1]).levels)
    assert set(indices) == {6, 7, 8, 9}


def test_an_environment_is_made_again_by_what_made_it(tmp_path: Path) -> None:
    env = NewFieldAtReset(_made("Hopper-v5", "hopper.xml", GRID, tmp_path), GRID)
    again = gymnasium.make(env.spec)
    assert again.unwrapped is not env.unwrapped
    for seed in (5, None, None):
        (seen, info), (same, other) = env.reset(seed=seed), again.reset(seed=seed)
        assert info["map"] == other["map"]
        assert np.array_equal(seen, same)


def test_what_is_no_model_with_the_blocks_is_refused() -> None:
    with pytest.raises(UserError, match=r"has no geom block_0_0; add the blocks by grid\.add_to"):
        NewFieldAtReset(Dropped(mujoco.MjSpec()), GRID)
    with pytest.raises(UserError, match="has no model of MuJoCo; use one of Gymnasium's MujocoEnv"):
        NewFieldAtReset(gymnasium.make("CartPole-v1"), GRID)
    with pytest.raises(ParameterError, match=r"grid: .* is not a BlockGrid of rsegen\.learning\.mujoco"):
        NewFieldAtReset(Dropped(mujoco.MjSpec()), [GRID])  # type: ignore[arg-type]


def test_a_robot_that_its_environment_puts_into_blocks_by_itself_is_refused(tmp_path: Path) -> None:
    env = NewFieldAtReset(_made("Hopper-v5", "hopper.xml", GRID, tmp_path), GRID)
    bare: Any = env.unwrapped

    def reset_model(height: float) -> Any:
        bare.data.qpos[:2] = 0.0, height  # and no set_state
        return bare._get_obs()

    deep, high = (float(GRID.ground(GRID.highest).heights([0.0, 0.0])) + z for z in (1.0, 1.3))
    bare.reset_model = lambda: reset_model(high)
    env.reset(seed=1)
    bare.reset_model = lambda: reset_model(deep)
    with pytest.raises(UserError, match=r"Hopper.* starts in the blocks: call set_state"):
        env.reset(options={"map": 0})
