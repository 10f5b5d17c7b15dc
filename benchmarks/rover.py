"""A small robot that learns to cross rubble: six wheels, two arms, and fields from flat to full difficulty."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import gymnasium
import mujoco
import numpy as np
from gymnasium.envs.mujoco import MujocoEnv

import rsegen
from rsegen.learning.gymnasium import NewFieldAtReset
from rsegen.learning.mujoco import BlockGrid

ROWS = 11
RUBBLE = rsegen.Recipe(
    name="rubble",
    seed=7,
    chunks=(2, 1),
    chunk_size=12,
    unit_cm=4,
    boundary="none",
    difficulty=(0, 1, ROWS),  # map 0 is flat, map 10 as designed, map 11 is flat again
    obstacles=[rsegen.Random(levels=5)],
)
FIELDS = 100_000  # of each row
START, LENGTH, SIDE = -1.5, 2.8, 0.5  # metres: where it starts, how far it has to go, how far aside it may get
SPEED, SECONDS = 0.2, 10.0  # m/s that it has to reach for the same row again, and the time of an episode
PATTERN = rsegen.scan_points((0.8, 0.4), 0.1) + np.array([0.15, 0])  # 9 x 5 heights, most of them ahead

WHEEL = '<body pos="{x} {y} 0"><joint class="wheel" name="{name}"/><geom class="wheel"/></body>'
ARM = """<body pos="{pivot} 0 0"><joint class="arm" name="{name}"/><geom class="arm" fromto="0 0 0 {tip} 0 0"/>
        {wheels}</body>"""


def robot() -> str:
    """Return the MJCF of the robot on a plane: two middle wheels, and an arm with two wheels at the front and rear."""
    pairs = {
        name: "".join(WHEEL.format(x=x, y=y, name=f"{name}_{side}") for side, y in (("left", 0.11), ("right", -0.11)))
        for name, x in (("middle", 0), ("front", 0.14), ("rear", -0.14))
    }
    arms = [
        ARM.format(name=name, pivot=pivot, tip=tip, wheels=pairs[name])
        for name, pivot, tip in (("front", 0.06, 0.14), ("rear", -0.06, -0.14))
    ]
    wheels = [f"{name}_{side}" for side in ("left", "right") for name in pairs]
    motors = [f'<velocity joint="{wheel}" kv="0.6" forcerange="-1.5 1.5"/>' for wheel in wheels]
    servos = [f'<position joint="{arm}" kp="12" kv="0.6" forcerange="-6 6"/>' for arm in ("front", "rear")]
    return f"""
<mujoco>
  <compiler angle="radian"/>
  <option timestep="0.01" integrator="implicitfast" cone="elliptic"/>
  <default>
    <geom condim="3" friction="0.8"/>
    <default class="wheel"><joint axis="0 1 0" armature="0.001"/><geom type="sphere" size="0.06" mass="0.15"/></default>
    <default class="arm"><joint axis="0 -1 0" range="-1 1" limited="true" damping="0.1" armature="0.01"/>
      <geom type="capsule" size="0.015" mass="0.1" contype="0" conaffinity="0"/></default>
  </default>
  <worldbody>
    <light pos="0 0 4"/>
    <geom type="plane" size="5 5 1" rgba="0.6 0.6 0.6 1"/>
    <body name="robot" pos="{START} 0 0.07">
      <freejoint/>
      <geom type="box" pos="0 0 0.03" size="0.12 0.06 0.03" mass="1.5" friction="0.3" rgba="0.9 0.6 0.2 1"/>
      {pairs["middle"]}{"".join(arms)}
    </body>
  </worldbody>
  <actuator>{"".join(motors + servos)}</actuator>
  <contact><exclude body1="robot" body2="robot"/></contact>
</mujoco>"""


class Rover(MujocoEnv):
    """Drives along +x. Actions, from -1 to 1: speed, turning, raising the front and the rear arm."""

    arms: Any = (0.0, 0.0)

    def __init__(self, file: str) -> None:
        super().__init__(file, frame_skip=10, observation_space=gymnasium.spaces.Box(-np.inf, np.inf, (17,)))
        self.action_space = gymnasium.spaces.Box(-1, 1, (4,), dtype=np.float32)

    def step(self, action: Any) -> Any:
        """Drive for 0.1 s. The reward is the distance, less a little for large actions and much for a failure."""
        speed, turning, *arms = np.clip(action, -1, 1)
        before = self.data.qpos[0]
        self.arms = np.clip(self.arms + 0.4 * np.array(arms), -1, 1)  # rad
        left, right = 6 * (speed - 0.5 * turning), 6 * (speed + 0.5 * turning)  # rad/s
        self.do_simulation([left] * 3 + [right] * 3 + [self.arms[0], -self.arms[1]], self.frame_skip)
        x, y = self.data.qpos[:2]
        failed = bool(abs(y) > SIDE or self.data.xmat[1, 8] < 0.3)  # off the blocks, or about to tip over
        reward = 10 * (x - before) - 0.005 * float(np.square(action).sum()) - 5 * failed
        return self._observation(), reward, failed or bool(x - START > LENGTH), False, {}

    def reset_model(self) -> Any:
        """Start before the blocks, the arms level."""
        self.arms = np.zeros(2)
        qpos = self.init_qpos.copy()
        qpos[1] = self.np_random.uniform(-0.2, 0.2)
        self.set_state(qpos, self.init_qvel)  # type: ignore[no-untyped-call]
        return self._observation()

    def _observation(self) -> Any:
        turn, velocity = self.data.xmat[1].reshape(3, 3), self.data.qvel
        arms = [*self.data.qpos[[9, 12]], *velocity[[8, 11]] / 5]
        moving = [*turn.T @ velocity[:3], *velocity[3:6] / 5]
        return np.concatenate([self.data.qpos[1:2], turn[:, 0], turn[2], moving, arms])


class Course(gymnasium.Wrapper[Any, Any, Any, Any]):
    """Adds the heights around the robot to its observation, and gives it a harder or an easier row after each episode.

    row: the only one, if there is no curriculum.
    """

    def __init__(self, env: NewFieldAtReset, row: int | None = None) -> None:
        super().__init__(env)
        self.row, self.is_curriculum = row or 0, row is None
        self.rng = np.random.default_rng(0)
        self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (17 + len(PATTERN),))
        self.episodes: list[tuple[int, float]] = []  # row, and distance in metres

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> Any:
        """Draw a field of the row; `options={"map": 17}` takes that one."""
        if seed is not None:
            self.rng = np.random.default_rng(seed)
        field = self.row + ROWS * int(self.rng.integers(FIELDS))
        observation, info = self.env.reset(seed=seed, options=options or {"map": field})
        return self._with_heights(observation), info

    def step(self, action: Any) -> Any:
        """Step, and choose the next row at the end of an episode."""
        observation, reward, terminated, truncated, info = self.env.step(action)
        if terminated or truncated:
            walked = float(self.unwrapped.data.qpos[0]) - START  # type: ignore[attr-defined]
            self.episodes.append((self.row, walked))
            if self.is_curriculum:
                rows, told = np.array([self.row]), SPEED * SECONDS
                self.row = int(rsegen.next_rows(rows, [walked], [told], count=ROWS, length=LENGTH, rng=self.rng)[0])
        return self._with_heights(observation), reward, terminated, truncated, info

    def _with_heights(self, observation: Any) -> Any:
        robot = self.unwrapped.data  # type: ignore[attr-defined]
        pose = [*robot.qpos[:3], np.arctan2(robot.xmat[1, 3], robot.xmat[1, 0])]
        return np.concatenate([observation, 5 * self.env.ground.scan(PATTERN, pose)]).astype(np.float32)  # type: ignore[attr-defined]


def course(recipe: rsegen.Recipe, row: int | None = None) -> Course:
    """Return the robot on the fields of a recipe: at one row, or in a curriculum."""
    grid, spec = BlockGrid(recipe), mujoco.MjSpec.from_string(robot())
    grid.add_to(spec)
    spec.compile()
    with TemporaryDirectory() as folder:
        file = Path(folder, "rover.xml")
        file.write_text(spec.to_xml(), "utf-8")
        rover = gymnasium.wrappers.TimeLimit(Rover(str(file)), round(SECONDS / 0.1))
    return Course(NewFieldAtReset(rover, grid), row)


def learner(row: int | None = None, seed: int = 1) -> Any:
    """Return PPO of Stable-Baselines3 with eight robots; `learner().learn(60_000)` takes a minute or two."""
    from stable_baselines3 import PPO
    from stable_baselines3.common.vec_env import DummyVecEnv

    robots = DummyVecEnv([partial(course, RUBBLE, row)] * 8)
    size = {"n_steps": 256, "batch_size": 256, "n_epochs": 10, "target_kl": 0.05}
    network = {"net_arch": [64, 64], "log_std_init": -0.5}
    return PPO("MlpPolicy", robots, 5e-4, **size, gamma=0.98, policy_kwargs=network, seed=seed, device="cpu")
