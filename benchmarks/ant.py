"""Gymnasium's Ant on blocks, which it sees and touches: the environment of benchmarks/ant_on_blocks.py."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import gymnasium
import mujoco
import numpy as np

import rsegen
from rsegen.learning.gymnasium import NewFieldAtReset
from rsegen.learning.mujoco import BlockGrid

ANT = Path(gymnasium.__file__).parent / "envs" / "mujoco" / "assets" / "ant.xml"
MIDDLE = 5.0
"""Metres from the start to the middle of the field, which is 8 x 4 m."""
PATTERN = rsegen.scan_points((1.6, 1.2), 0.2) + np.array([0.4, 0.0])
EPISODE = 500
"""Steps of 0.05 s."""


class AntOnBlocks(gymnasium.Wrapper[Any, Any, Any, Any]):
    """Ant-v5 on a new field at each reset, which sees the ground around it; infos have its `touches` of blocks."""

    def __init__(self, seed: int) -> None:
        recipe = rsegen.Recipe(
            name="low-blocks",
            seed=seed,
            unit_cm=4,
            block_width_cm=40,
            chunks=(2, 1),
            chunk_size=10,
            boundary="none",
            obstacles=[rsegen.Random(levels=4)],
        )
        grid, spec = BlockGrid(recipe, pos=(MIDDLE, 0, 0)), mujoco.MjSpec.from_file(str(ANT))
        grid.add_to(spec)
        spec.compile()
        with TemporaryDirectory() as folder:
            file = Path(folder, "ant.xml")
            file.write_text(spec.to_xml(), "utf-8")
            plain = gymnasium.make("Ant-v5", xml_file=str(file), max_episode_steps=EPISODE)
        self._fields = NewFieldAtReset(plain, grid)
        super().__init__(self._fields)
        numbers = len(plain.observation_space.sample()) + len(PATTERN)
        self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (numbers,))
        model = plain.unwrapped.model  # type: ignore[attr-defined]
        first = model.geom(grid.names[0]).id
        self._blocks = range(first, first + len(grid.names))

    def reset(self, **given: Any) -> tuple[Any, dict[str, Any]]:
        """As NewFieldAtReset, with what it sees."""
        observation, info = self.env.reset(**given)
        return self._with_ground(observation), info

    def step(self, action: Any) -> Any:
        """As Ant-v5, with what it sees and touches."""
        observation, reward, is_over, is_late, info = self.env.step(action)
        pairs = self.env.unwrapped.data.contact.geom  # type: ignore[attr-defined]
        info["touches"] = int(np.isin(pairs, self._blocks).any(axis=1).sum()) if len(pairs) else 0
        return self._with_ground(observation), reward, is_over, is_late, info

    def _with_ground(self, observation: Any) -> Any:
        x, y, z, w, i, j, k = self.env.unwrapped.data.qpos[:7]  # type: ignore[attr-defined]
        yaw = np.arctan2(2 * (i * j + w * k), 1 - 2 * (j * j + k * k))
        return np.concatenate([observation, self._fields.ground.scan(PATTERN, np.array([x, y, z, yaw]))])
