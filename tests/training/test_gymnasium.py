"""A crawler that learns to cross fields: what it does moves it, what it sees is there, and it touches blocks."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest

from rsegen import Random, Recipe, build
from rsegen.errors import ParameterError
from rsegen.field.stepfield import Array

gymnasium = pytest.importorskip("gymnasium", reason="Gymnasium is not installed")
pytest.importorskip("mujoco", reason="MuJoCo is not installed")
from gymnasium.utils.env_checker import check_env  # noqa: E402

from rsegen.training.crossing import Crossing  # noqa: E402  # they need MuJoCo
from rsegen.training.gymnasium import CrossingEnv  # noqa: E402

RECIPE = Recipe(seed=11, unit_cm=5, chunks=(2, 1), boundary="none", obstacles=[Random(levels=3)])
EAST, REST = 1.0, -0.275  # actions: full speed; the angle at which flippers are held
SIDES = 2  # flippers of the crawler


@pytest.fixture
def env() -> CrossingEnv:
    return CrossingEnv(Crossing(recipe=RECIPE))


def _ahead(env: CrossingEnv, observation: Array, flippers: float = REST) -> Array:
    """Half speed, and back to the east; the heading is seen before the place, the flippers and the action."""
    sine, cosine = observation[-3 - 2 * SIDES - 2], observation[-3 - 2 * SIDES - 1]
    turn = np.clip(-2 * np.arctan2(sine, cosine), -1, 1)
    return np.array([EAST / 2, turn, *[flippers] * len(env.flippers)])


@pytest.mark.filterwarnings("ignore:.*A Box observation space")  # as those of MuJoCo in Gymnasium
@pytest.mark.filterwarnings("ignore:.*alternative render modes due to the environment not having a spec")
def test_gymnasium_takes_it_for_an_environment(env: CrossingEnv) -> None:
    check_env(env, skip_render_check=True)
    check_env(CrossingEnv(env.crossing, render_mode="rgb_array"))
    assert env.action_space.shape == (2 + SIDES,)


def test_a_copy_for_another_process_is_the_same_environment(env: CrossingEnv) -> None:
    again = pickle.loads(pickle.dumps(env))  # noqa: S301  # our own
    assert np.array_equal(again.reset(seed=3)[0], env.reset(seed=3)[0])
    action = np.array([EAST, 0.1, REST, REST])
    for _ in range(3):
        assert np.array_equal(again.step(action)[0], env.step(action)[0])


def test_what_it_sees_is_in_its_own_frame(env: CrossingEnv) -> None:
    """Turned anyhow, by MuJoCo's own rotations; the ground next to it by the level of the cell under each point."""
    import mujoco

    crossing, rng = env.crossing, np.random.default_rng(5)
    levels = build(RECIPE, 0).levels
    place, quaternion, velocity = np.array([0.23, -0.31, 0.55]), np.array([0.9, 0.2, -0.3, 0.25]), rng.normal(size=6)
    quaternion /= np.linalg.norm(quaternion)
    turn = np.empty((3, 3))
    mujoco.mju_quat2Mat(turn.reshape(9), quaternion)
    angles, action = np.array([[0.1, 0.2]]), np.array([[0.3, 0.4, 0.5, 0.6]])
    state = np.concatenate([place, quaternion])[None]
    (seen,) = crossing.observe(state, velocity[None], angles, action, crossing.grid.ground(levels[None]))
    points, yaw = len(crossing.pattern), np.arctan2(turn[1, 0], turn[0, 0])
    rest = [
        *turn[2],
        *(turn.T @ velocity[:3]),
        *velocity[3:],
        *(np.sin(yaw), np.cos(yaw), place[1] / 0.5, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6),
    ]
    assert seen[points:] == pytest.approx(rest)
    along, across = crossing.pattern.T
    x = place[0] + np.cos(yaw) * along - np.sin(yaw) * across
    y = place[1] + np.sin(yaw) * along + np.cos(yaw) * across
    i, j = np.floor(x / 0.1 + 10).astype(int), np.floor(y / 0.1 + 5).astype(int)
    is_on_it = (i >= 0) & (i < 20) & (j >= 0) & (j < 10)
    heights = np.where(is_on_it, 0.05 * levels[np.clip(i, 0, 19), np.clip(j, 0, 9)], 0)
    assert is_on_it.mean() > 0.2
    assert seen[:points] == pytest.approx(np.clip(heights - place[2], -0.5, 0.5) / 0.5)


def test_it_sees_the_ground_under_it_and_on_all_sides(env: CrossingEnv) -> None:
    body, pattern = env.crossing.driven.body_or_box, env.crossing.pattern
    beyond = np.array([*(body.low[:2] - pattern.min(axis=0)), *(pattern.max(axis=0) - body.high[:2])])
    assert beyond == pytest.approx([0.0, 0.1, 0.8, 0.1])  # behind, right, ahead, left
    assert np.diff(np.unique(pattern[:, 0].round(6))).max() < RECIPE.block_width_cm / 100


def test_it_crosses_low_blocks_and_touches_them(env: CrossingEnv) -> None:
    outcomes = []
    for seed in range(4):
        observation, info = env.reset(seed=seed)
        assert info["touches"] == 0
        touches, total, begin = 0, 0.0, info["x"]
        for _ in range(env.crossing.periods):
            observation, reward, is_over, is_late, info = env.step(_ahead(env, observation))
            touches, total = touches + info["touches"], total + reward
            if is_over or is_late:
                break
        outcomes.append(info["is_across"])
        assert touches > 50
        way = info["x"] - begin
        assert way - 3 < total - 5 * info["is_across"] < way, "a reward for the way, less what time and turning cost"
    assert sum(outcomes) >= 2


def test_flippers_turn_as_they_are_told_and_no_faster(env: CrossingEnv) -> None:
    env.reset(seed=1)
    data, at = env.world.data, env.flippers[0].angle_at
    assert data.qpos[at] == pytest.approx(0.25, abs=0.01)
    angles = []
    for _ in range(15):
        observation, *_ = env.step(np.array([0.0, 0.0, 0.0, 0.0]))  # the middle of -1.2 to 2.8 rad
        angles.append(data.qpos[at])
        assert observation[-4 - SIDES : -4] == pytest.approx(data.qpos[[f.angle_at for f in env.flippers]], abs=1e-6)
    assert angles[-1] == pytest.approx(0.8, abs=0.03)
    assert max(np.diff(angles)) < 1.5 * 0.1 + 0.03


def test_it_sees_the_ground_where_it_is(env: CrossingEnv) -> None:
    observation, _ = env.reset(seed=3)
    for _ in range(25):
        observation, *_ = env.step(_ahead(env, observation))
    x, y, z, w, i, j, k = env.world.data.qpos[:7]
    yaw = np.arctan2(2 * (i * j + w * k), 1 - 2 * (j * j + k * k))
    turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
    width, levels = 0.1, env.ground.levels[0]
    expected = []
    for point in env.crossing.pattern @ turn.T + (x, y):
        cell = np.floor(point / width).astype(int) + np.array(levels.shape) // 2
        is_inside = (cell >= 0).all() and (cell < levels.shape).all()
        expected.append(np.clip((0.05 * levels[tuple(cell)] if is_inside else 0.0) - z, -0.5, 0.5) / 0.5)
    assert observation[: len(expected)] == pytest.approx(np.array(expected), abs=1e-5)
    assert np.ptp(expected) > 0.1, "it has blocks before it"


def test_the_same_seed_is_the_same_episode(env: CrossingEnv) -> None:
    def run(other: CrossingEnv) -> list[Any]:
        observation, info = other.reset(seed=5)
        seen = [observation, info["map"]]
        for _ in range(10):
            observation, reward, *_ = other.step(_ahead(other, observation))
            seen += [observation, reward]
        return seen

    first, again, elsewhere = run(env), run(env), run(CrossingEnv(env.crossing))
    for one, two, three in zip(first, again, elsewhere, strict=True):
        assert np.array_equal(one, two)
        assert np.array_equal(one, three)
    env.reset(seed=6)
    assert env.reset(seed=6, options={"map": 7})[1]["map"] == 7


def test_what_tips_over_or_leaves_its_lane_has_failed(env: CrossingEnv) -> None:
    crossing = env.crossing
    finish, half = crossing.lane[1:]
    upright, on_its_side = (1, 0, 0, 0), (0.7, 0.71, 0, 0)
    places = [(0, 0, 0.1, *upright), (finish, 0, 0, *upright), (0, 0, 0.1, *on_its_side), (0, 1.01 * half, 0, *upright)]
    found = crossing.judge(np.array([-0.1, finish - 0.1, -0.1, -0.1]), np.array(places))
    assert found.is_across.tolist() == [False, True, False, False]
    assert found.has_failed.tolist() == [False, False, True, True]
    assert found.reward == pytest.approx([0.09, 5.09, -1.91, -1.91])


def test_held_flippers_stay_where_they_are() -> None:
    env = CrossingEnv(Crossing(recipe=RECIPE, uses_flippers=False))
    assert env.action_space.shape == (2,)
    env.reset(seed=1)
    angle = env.world.data.joint("robot/left_flipper_pivot")
    for _ in range(10):
        env.step(np.array([0.5, 0.0]))
    assert angle.qpos[0] == pytest.approx(0.25, abs=0.03)


def test_robots_on_wheels_cross_too() -> None:
    recipe = Recipe(seed=3, unit_cm=1, chunk_size=10, boundary="none", obstacles=[Random(levels=3)])
    env = CrossingEnv(Crossing(recipe=recipe, robot="jackal"))
    assert env.flippers == []
    env.reset(seed=2)
    touches = 0
    for _ in range(60):
        *_, is_over, _, info = env.step(np.array([0.4, 0.0]))
        touches += info["touches"]
        if is_over:
            break
    assert info["is_across"]
    assert touches > 20


def test_fields_of_several_frictions_are_refused() -> None:
    recipe = Recipe(boundary="none", level_friction=(0.2, 0.9), obstacles=[Random(levels=3)])
    with pytest.raises(ParameterError, match="level_friction"):
        Crossing(recipe=recipe)


def test_a_period_of_no_time_is_refused() -> None:
    with pytest.raises(ParameterError, match="period"):
        Crossing(recipe=RECIPE, period=0.0)
    with pytest.raises(ParameterError, match="seconds: inf is not a finite number"):
        Crossing(recipe=RECIPE, seconds=np.inf)
    with pytest.raises(ParameterError, match="period: 'a' is not a number"):
        Crossing(recipe=RECIPE, period="a")  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match=r"flipper_speed: -1 is outside 0\.\.1000 rad/s"):
        Crossing(recipe=RECIPE, flipper_speed=-1)


def test_a_value_of_another_class_is_refused(env: CrossingEnv) -> None:
    with pytest.raises(ParameterError, match="recipe: 'rubble' is not a recipe"):
        Crossing(recipe="rubble")  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match="uses_flippers: 'held' is neither yes nor no"):
        Crossing(recipe=RECIPE, uses_flippers="held")  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match=r"crossing: .* is not a Crossing of rsegen\.training\.crossing"):
        CrossingEnv(RECIPE)  # type: ignore[arg-type]


def test_a_step_before_the_first_reset_is_refused(env: CrossingEnv) -> None:
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step(np.zeros(4))


def test_videos_of_long_periods_have_a_picture_per_second_at_least() -> None:
    assert CrossingEnv(Crossing(recipe=RECIPE, period=3.0)).metadata["render_fps"] == 1


@pytest.mark.parametrize(
    "action", ["abc", [[0.0], [0.0, 0.0]], [0.0], [0.0, np.nan, 0.0, 0.0], [np.inf] * 4, None, 0.5, np.zeros((1, 4))]
)
def test_an_action_that_is_none_is_refused_and_changes_nothing(env: CrossingEnv, action: Any) -> None:
    observation, _ = env.reset(seed=5)
    with pytest.raises(ParameterError, match=r"^action: .*; expected 4 finite numbers from -1 to 1$"):
        env.step(action)
    assert env.world.data.time == 0
    again, _ = env.reset(seed=5)
    assert np.array_equal(observation, again)


def test_a_belt_that_was_wedged_at_the_end_of_an_episode_runs_in_the_next_one(env: CrossingEnv) -> None:
    world = env.world
    world.belts._wedged = {0}  # as if the last step had wedged it
    env.reset(seed=5)
    world.drive("robot", env.crossing.driven, 0.5, 0.0)
    assert set(world.shapes.speed) == {0.0, 0.5}


def test_pictures_show_the_robot_as_it_comes_on_and_the_map_of_each_reset() -> None:
    env = CrossingEnv(Crossing(recipe=RECIPE), render_mode="rgb_array")
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.render()
    env.reset(seed=3)
    first = env.render()
    assert (first.shape, first.dtype) == ((360, 640, 3), np.uint8)
    assert len(np.unique(first.reshape(-1, 3), axis=0)) > 20
    for _ in range(5):
        env.step(np.array([EAST, 0, REST, REST]))
    moved = np.abs(env.render().astype(int) - first).max(axis=2) > 20
    assert 0.002 < moved.mean() < 0.1, "the robot has moved, and the map is as it was"
    env.reset(seed=3)
    assert np.array_equal(env.render(), first)
    env.reset(seed=4)
    assert (np.abs(env.render().astype(int) - first).max(axis=2) > 20).mean() > 0.02


def test_render_modes_are_those_of_the_metadata(env: CrossingEnv) -> None:
    env.reset(seed=1)
    with pytest.warns(UserWarning, match="render_mode"):
        assert env.render() is None
    with pytest.raises(ParameterError, match=r"unknown mode 'human'.*rgb_array"):
        CrossingEnv(env.crossing, render_mode="human")
    pictures = gymnasium.wrappers.RenderCollection(CrossingEnv(env.crossing, render_mode="rgb_array"))
    pictures.reset(seed=1)
    pictures.step(np.zeros(4))
    assert len(pictures.render()) == 2
