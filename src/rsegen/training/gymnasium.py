"""Gymnasium environment in which a robot on tracks or wheels crosses fields, another field at each reset.

    env = CrossingEnv(Crossing(recipe, robot="crawler"))
    observation, info = env.reset(seed=7)    # info["map"] is the index of the map
    observation, reward, is_across_or_failed, is_late, info = env.step(env.action_space.sample())

It is driven in MuJoCo as by `rsegen drive --simulator mujoco`, step by step. With `render_mode="rgb_array"` `render`
returns pictures as in the videos of drives, which need neither a screen nor OpenGL.
"""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np

from rsegen.driving.filming import VIDEO, RobotView
from rsegen.errors import ParameterError, UnknownName, refuse_other, shown
from rsegen.field.stepfield import Array
from rsegen.learning.ground import Ground
from rsegen.learning.gymnasium import MapDraws
from rsegen.scene.scene import compose
from rsegen.training.crossing import NAME, Crossing


class CrossingEnv(gymnasium.Env[Any, Any]):
    """Environment of one world; actions are from -1 to 1: the speed, the turn rate, and the angle of each flipper.

    Infos have the index of the `map`, whether the robot `is_across`, its `x`, metres, and how many contacts it has with
    blocks, `touches`.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"]}  # noqa: RUF012  # as in Gymnasium's Env

    def __init__(self, crossing: Crossing, render_mode: str | None = None) -> None:
        refuse_other("crossing", crossing, Crossing)
        if render_mode is not None and render_mode not in self.metadata["render_modes"]:
            raise UnknownName.among("render_mode", "mode", render_mode, self.metadata["render_modes"])
        self.crossing, self.render_mode = crossing, render_mode
        self.metadata = {**type(self).metadata, "render_fps": max(round(1 / crossing.period), 1)}
        self._view: RobotView | None = None
        self.world = crossing.world()
        self.flippers = crossing.flippers(self.world)
        self.ground: Ground = crossing.grid.ground(crossing.grid.highest[None])
        self._draws = MapDraws(crossing.recipe, np.random.default_rng())
        self._angles_at = [flipper.angle_at for flipper in self.flippers]
        self._targets_at = [flipper.target_at for flipper in self.flippers]
        self.action_space = gymnasium.spaces.Box(-1, 1, (2 + len(self.flippers),), np.float32)
        self._action = np.zeros((1, 2 + len(self.flippers)))
        self._periods, self._map = 0, -1
        self._rest = np.array([[flipper.rest for flipper in self.flippers]])
        self._targets = self._rest
        numbers = self._observed().shape[-1]
        self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (numbers,), np.float32)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        """Draw a map and a start; `options={"map": 17}` takes that map. A seed starts the draws anew."""
        super().reset(seed=seed)
        if seed is not None:
            self._draws = MapDraws(self.crossing.recipe, np.random.default_rng(seed))
        self._map, levels = self._draws.next(options)
        self._view = None
        self.crossing.grid.write(self.world.model, levels)
        self.ground.write(levels[None])
        self.world.restart(NAME, self.crossing.start(*self.np_random.uniform(-1, 1, 2)))
        self._action, self._targets, self._periods = np.zeros_like(self._action), self._rest, 0
        return self._observed()[0], self._info(is_across=False)

    def step(self, action: Array) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Drive for a period; ParameterError for an action of another shape, or with a value that is not finite."""
        if self._map < 0:
            raise gymnasium.error.ResetNeeded("reset the environment before its first step")
        crossing, data = self.crossing, self.world.data
        self._action = self._checked(action)
        before = np.array([data.qpos[0]])
        v, w = crossing.speeds(self._action)
        self._targets = crossing.angles(self._action, self._targets, self.flippers)
        data.ctrl[self._targets_at] = self._targets[0]
        self.world.drive(NAME, crossing.driven, float(v[0]), float(w[0]))
        self.world.step(crossing.steps)
        self._periods += 1
        outcome = crossing.judge(before, data.qpos[None, :7])
        is_across, is_over = bool(outcome.is_across[0]), bool(outcome.is_across[0] | outcome.has_failed[0])
        is_late = not is_over and self._periods >= crossing.periods
        return self._observed()[0], float(outcome.reward[0]), is_over, is_late, self._info(is_across=is_across)

    def render(self) -> Any:
        """Return a picture of the robot on its map, uint8, (height, width, 3); None without a `render_mode`."""
        if self.render_mode is None:
            gymnasium.logger.warn('make the environment with render_mode="rgb_array" to have it rendered')
            return None
        if self._map < 0:
            raise gymnasium.error.ResetNeeded("reset the environment before it is rendered")
        if self._view is None:
            self._view = RobotView(compose(self.crossing.recipe, self._map), [self.crossing.placed], VIDEO)
        return self._view.picture(self.world.link_poses())

    def _checked(self, action: Any) -> Array:
        try:
            values = np.asarray(action, dtype=float)
        except (TypeError, ValueError):
            values = np.empty(0)
        if values.shape != self._action.shape[1:] or not np.isfinite(values).all():
            text = shown(action.tolist() if isinstance(action, np.ndarray) else action)
            raise ParameterError("action", f"{text}; expected {self._action.shape[1]} finite numbers from -1 to 1")
        return np.asarray(np.clip(values, -1, 1)[None])

    def _observed(self) -> Array:
        data = self.world.data
        angles = data.qpos[self._angles_at][None]
        seen = self.crossing.observe(data.qpos[None, :7], data.qvel[None, :6], angles, self._action, self.ground)
        return np.asarray(seen, dtype=np.float32)

    def _info(self, *, is_across: bool) -> dict[str, Any]:
        data, blocks = self.world.data, self.crossing.blocks
        pairs = data.contact.geom
        touches = int(((pairs >= blocks.start) & (pairs < blocks.stop)).any(axis=1).sum())
        return {"map": self._map, "is_across": is_across, "x": float(data.qpos[0]), "touches": touches}
