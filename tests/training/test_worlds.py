"""Thousands of crossings at once are those of one: what robots see and get, and PPO of rsl_rl learns a step in them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import rsegen
from rsegen import Random, Recipe
from rsegen.errors import ParameterError
from tests.support.late_import import LateImport

for name, what in (("mujoco", "MuJoCo"), ("gymnasium", "Gymnasium"), ("torch", "PyTorch"), ("rsl_rl", "rsl_rl")):
    pytest.importorskip(name, reason=f"{what} is not installed")
from rsegen.simulators.poses import Pose  # noqa: E402
from rsegen.training.crossing import NAME, Crossing  # noqa: E402  # they need all of these
from rsegen.training.gymnasium import CrossingEnv  # noqa: E402

torch = LateImport("torch", reason="PyTorch is not installed")
adapter = LateImport("rsegen.training.worlds", reason="mujoco_warp is not installed")

pytestmark = [
    pytest.mark.long(reason="Warp and PyTorch, which no make brings"),
    pytest.mark.slow,
    pytest.mark.filterwarnings("ignore"),  # of the libraries
]

RECIPE = Recipe(
    seed=11, unit_cm=5, chunks=(2, 1), boundary="none", maps=6, difficulty=(0.5, 1, 3), obstacles=[Random(levels=4)]
)
WORLDS = 3


@pytest.fixture
def crossing() -> Crossing:
    return Crossing(recipe=RECIPE, seconds=4)


@pytest.fixture
def worlds(crossing: Crossing) -> Any:
    return adapter.CrossingWorlds(crossing, WORLDS, device="cpu", maps=6, seed=4)


def _twin(worlds: Any, world: int) -> CrossingEnv:
    """The environment of one world with the same map and the same start."""
    crossing = worlds.crossing
    env = CrossingEnv(crossing)
    env.reset(seed=1, options={"map": int(worlds.map[world])})
    x, y, z, w, *_, k = worlds.many.poses()[world]
    env.world.restart(NAME, Pose(x=x, y=y, z=z, yaw=2 * np.arctan2(k, w)))
    return env


def test_worlds_are_as_the_environment_of_one(worlds: Any) -> None:
    twins = [_twin(worlds, world) for world in range(WORLDS)]
    assert len({int(index) for index in worlds.map}) > 1
    actions = np.array([[0.6, 0.1, 0.2, 0.3], [0.4, -0.1, -0.3, 0.0], [0.8, 0.0, -0.5, -0.5]])
    touches = 0
    for _ in range(6):
        seen, rewards, _, _ = worlds.step(torch.as_tensor(actions, dtype=torch.float32))
        for world, env in enumerate(twins):
            own, reward, *_, info = env.step(actions[world])
            points = len(env.crossing.pattern)
            seen_here = seen["policy"][world].numpy()
            # A point at an edge may be on either side of it; speeds after a blow differ most.
            assert np.isclose(seen_here[:points], own[:points], atol=0.03).mean() > 0.98
            rest = np.r_[points : points + 3, points + 9 : len(own)]
            assert seen_here[rest] == pytest.approx(own[rest], abs=0.06)
            assert float(rewards[world]) == pytest.approx(reward, abs=0.002)
            touches += info["touches"]
    assert touches > 0


def test_what_is_done_begins_anew_on_a_field_that_is_drawn(worlds: Any) -> None:
    worlds._qpos[1, :3] = torch.tensor([worlds.crossing.lane[1] + 0.1, 0.0, 0.01])
    worlds._qpos[2, 3:7] = torch.tensor([0.7, 0.714, 0.0, 0.0])
    seen, rewards, done, extras = worlds.step(torch.zeros((WORLDS, worlds.num_actions)))
    assert done.tolist() == [0, 1, 1]
    assert worlds.ended["is_across"].tolist() == [False, True, False]
    assert worlds.ended["has_failed"].tolist() == [False, False, True]
    assert rewards[1] > 4
    assert rewards[2] < -1
    assert worlds._qpos[1:, 0].tolist() == pytest.approx([worlds.crossing.lane[0]] * 2)
    assert worlds.episode_length_buf.tolist() == [1, 0, 0]
    assert not extras["time_outs"].any()
    assert torch.isfinite(seen["policy"]).all()


def test_the_map_of_each_world_is_the_one_that_it_touches_and_sees(worlds: Any) -> None:
    worlds.begin(torch.arange(WORLDS), torch.tensor([2, 5, 4]))
    levels = rsegen.build_many(RECIPE, [2, 5, 4])
    assert not np.array_equal(levels[0], levels[1])
    grid, first = worlds.crossing.grid, worlds.crossing.blocks.start
    part = slice(first, worlds.crossing.blocks.stop)
    assert worlds.many.model.geom_pos.numpy()[:, part] == pytest.approx(grid.pos(levels), abs=1e-6)
    assert worlds.many.model.geom_size.numpy()[:, part] == pytest.approx(grid.size(levels), abs=1e-6)
    assert worlds.many.data.geom_xpos.numpy()[:, part] == pytest.approx(grid.pos(levels), abs=1e-6)
    assert worlds.ground.levels.numpy().tolist() == levels.tolist()


def test_actions_of_double_precision_are_those_of_single_precision(worlds: Any) -> None:
    worlds.step(torch.zeros((WORLDS, 4), dtype=torch.float64))
    assert worlds.get_observations()["policy"].dtype == torch.float32
    with pytest.raises(ParameterError, match=r"actions: of shape \(3, 2\); expected \(3, 4\)"):
        worlds.step(torch.zeros((WORLDS, 2)))


@pytest.mark.parametrize("given", [{"worlds": 0}, {"maps": 0}, {"seed": -1}], ids=str)
def test_counts_and_seeds_that_are_none_are_refused(crossing: Crossing, given: dict[str, int]) -> None:
    with pytest.raises(ParameterError, match=f"{next(iter(given))}: "):
        adapter.CrossingWorlds(crossing, **{"worlds": 2, "device": "cpu", **given})


def test_ppo_of_rsl_rl_takes_a_step(worlds: Any) -> None:
    from rsl_rl.runners import OnPolicyRunner

    from benchmarks.flippers import settings

    runner = OnPolicyRunner(worlds, settings(1) | {"num_steps_per_env": 4}, log_dir=None, device="cpu")
    before = [part.clone() for part in runner.alg.get_policy().parameters()]
    runner.learn(1)
    after = list(runner.alg.get_policy().parameters())
    assert any(not torch.equal(one, other) for one, other in zip(before, after, strict=True))
    assert all(torch.isfinite(part).all() for part in after)


def test_a_recipe_of_one_map_is_drawn_by_the_seed(crossing: Crossing) -> None:
    one = replace(crossing, recipe=replace(RECIPE, maps=1, difficulty=1.0))
    first, again, other = (
        adapter.CrossingWorlds(one, WORLDS, device="cpu", maps=4, seed=seed).levels for seed in (1, 1, 2)
    )
    assert torch.equal(first, again)
    assert not torch.equal(first, other)
