"""Thousands of worlds of mujoco_warp, in each of which a robot on tracks or wheels crosses fields, for torch.

    worlds = CrossingWorlds(Crossing(recipe, robot="crawler"), 4096, device="cuda:0")
    runner = rsl_rl.runners.OnPolicyRunner(worlds, settings, device="cuda:0")

`CrossingWorlds` is a VecEnv of rsl_rl (5.4), the trainer of mjlab and Isaac Lab: a world that is done begins anew at
once, on another field. All arrays stay on the device; after each period the host only reads which worlds begin anew.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import torch
import warp as wp
from rsl_rl.env import VecEnv
from tensordict import TensorDict

from rsegen.errors import ParameterError, refuse_other
from rsegen.learning.ground import Ground
from rsegen.learning.mujoco_warp import BlocksOfWorlds
from rsegen.mujoco.many_worlds import ManyWorlds
from rsegen.params.sorts import Integer
from rsegen.params.streams import SEEDS
from rsegen.recipe.batch import build_many
from rsegen.training.crossing import Crossing

_COUNT, _SEED = Integer(1), Integer(0, SEEDS - 1)


class CrossingWorlds(VecEnv):  # type: ignore[misc]  # rsl_rl has no types for mypy
    """Worlds of a crossing; actions are as in `CrossingEnv`, observations are `policy`, (worlds, numbers).

    maps: number of fields that are built in advance, by the recipe and this seed; each start draws one of them. If the
    recipe has several maps, these are repeated in equal numbers.
    ended: of the last period, (worlds,) each: `is_across`, `has_failed`, `is_late`, the `map`, and `touched`
    touched: periods of the episode at whose end the robot touched blocks, (worlds,)
    """

    def __init__(
        self, crossing: Crossing, worlds: int, *, device: str = "cuda:0", maps: int = 16384, seed: int = 0
    ) -> None:
        refuse_other("crossing", crossing, Crossing)
        worlds, maps, seed = _COUNT.check("worlds", worlds), _COUNT.check("maps", maps), _SEED.check("seed", seed)
        self.crossing, self.device = crossing, device
        self.num_envs, self.max_episode_length = worlds, crossing.periods
        self.cfg = {"robot": crossing.driven.kind, "recipe": crossing.recipe.name, "worlds": worlds}
        # One world is compiled, with all blocks as high as the highest; its copies get the levels of their fields.
        compiled = crossing.world()
        self.flippers = crossing.flippers(compiled)
        self.num_actions = 2 + len(self.flippers)
        self.many = ManyWorlds(compiled, worlds, device=device)
        self._blocks = BlocksOfWorlds(crossing.grid, compiled.model, self.many.model, self.many.data)
        recipe, random = crossing.recipe, np.random.default_rng(seed)
        indices = random.integers(SEEDS, size=maps) if recipe.maps == 1 else np.resize(recipe.indices, maps)
        self.levels = torch.as_tensor(build_many(recipe, indices.tolist()), device=device)
        self._random = torch.Generator(device).manual_seed(seed)
        # Tensors of torch on the memory of Warp's arrays: what is written into them is in the simulation.
        state = self.many.data
        self._qpos, self._qvel, self._ctrl = (wp.to_torch(part) for part in (state.qpos, state.qvel, state.ctrl))
        self._still = [
            wp.to_torch(part)
            for part in (state.qvel, state.qacc, state.qacc_warmstart, self.many.now, self.many.wedged)
        ]
        self._speeds = wp.to_torch(self.many.speeds)
        self._first = self._qpos[0].clone()
        self._angles_at = [flipper.angle_at for flipper in self.flippers]
        self._targets_at = [flipper.target_at for flipper in self.flippers]
        self._rest = torch.tensor([flipper.rest for flipper in self.flippers], device=device)
        self._servos_at_rest = self._ctrl[0].clone()
        self.episode_length_buf = torch.zeros(worlds, dtype=torch.long, device=device)
        self.touched = torch.zeros(worlds, dtype=torch.long, device=device)
        self.map = torch.zeros(worlds, dtype=torch.long, device=device)
        self._targets = self._rest.repeat(worlds, 1)
        self._action = torch.zeros((worlds, self.num_actions), device=device)
        self.ground: Ground = crossing.grid.ground(self.levels[self.map])
        self.ended: dict[str, Any] = {}
        self.begin(torch.arange(worlds, device=device))

    def begin(self, rows: Any, maps: Any = None) -> None:
        """Begin worlds anew; rows: their indices; maps: indices of their fields in `levels`, by default drawn."""
        count, random = len(rows), {"generator": self._random, "device": self.device}
        self.map[rows] = torch.randint(len(self.levels), (count,), **random) if maps is None else maps
        levels = self.levels[self.map[rows]]
        self._blocks.write(levels, rows)
        self.ground.write(levels, rows)
        start, drawn = self._first.repeat(count, 1), 2 * torch.rand((count, 2), **random) - 1
        aside, heading = self.crossing.spread
        start[:, 1] = drawn[:, 0] * aside
        half = drawn[:, 1] * heading / 2
        start[:, 3:7] = torch.stack([half.cos(), half * 0, half * 0, half.sin()], -1)
        self._qpos[rows] = start
        for part in self._still:
            part[rows] = 0
        self._ctrl[rows], self._targets[rows] = self._servos_at_rest, self._rest
        self._action[rows], self.episode_length_buf[rows], self.touched[rows] = 0, 0, 0

    def get_observations(self) -> Any:
        """Return the observations of all worlds now."""
        angles = self._qpos[:, self._angles_at]
        seen = self.crossing.observe(self._qpos[:, :7], self._qvel[:, :6], angles, self._action, self.ground)
        return TensorDict({"policy": seen}, batch_size=[self.num_envs], device=self.device)

    def step(self, actions: Any) -> tuple[Any, Any, Any, dict[str, Any]]:
        """Drive for a period; return observations, rewards, which worlds have begun anew, and rsl_rl's extra values."""
        crossing = self.crossing
        if actions.shape != self._action.shape:
            problem = f"of shape {tuple(actions.shape)}; expected {tuple(self._action.shape)}"
            raise ParameterError("actions", problem)
        self._action = actions.to(self._action.dtype).clamp(-1, 1)
        before = self._qpos[:, 0].clone()
        v, w = crossing.speeds(self._action)
        self._speeds.copy_(torch.stack(self.many.sides(v, w), -1))
        if self.flippers:
            self._targets = crossing.angles(self._action, self._targets, self.flippers)
            self._ctrl[:, self._targets_at] = self._targets
        self.many.step(crossing.steps)
        self.episode_length_buf += 1
        self.touched += wp.to_torch(self.many.touches(crossing.blocks)) > 0
        # A world whose physics has failed counts as failed, and its reward, which may be NaN, as 0.
        outcome = crossing.judge(before, self._qpos[:, :7])
        has_failed = outcome.has_failed | ~torch.isfinite(self._qpos).all(dim=-1)
        is_late = ~(outcome.is_across | has_failed) & (self.episode_length_buf >= self.max_episode_length)
        is_done = outcome.is_across | has_failed | is_late
        rewards = torch.nan_to_num(outcome.reward)
        # What ended is noted before its worlds begin anew; observations are of the new starts, as rsl_rl wants them.
        self.ended = {
            "is_across": outcome.is_across,
            "has_failed": has_failed,
            "is_late": is_late,
            "map": self.map.clone(),
            "touched": self.touched.clone(),
        }
        rows = is_done.nonzero()[:, 0]
        if len(rows):
            self.begin(rows)
        return self.get_observations(), rewards, is_done.long(), {"time_outs": is_late}
