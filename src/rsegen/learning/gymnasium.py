"""Gymnasium: a wrapper that gives an environment of MuJoCo a new field at each reset.

    env = NewFieldAtReset(gymnasium.make("Ant-v5", xml_file="./ant_on_blocks.xml"), grid)
    observation, info = env.reset(seed=7)    # info["map"] is the index of the map

The model has the blocks of the grid: `grid.add_to(spec)`.
"""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np

from rsegen.errors import UserError
from rsegen.learning.mujoco import BlockGrid
from rsegen.params.streams import SEEDS
from rsegen.recipe.batch import build_many


class NewFieldAtReset(gymnasium.Wrapper[Any, Any, Any, Any]):
    """Draws a map of the grid's recipe at each reset, by the seed of the resets; of a recipe of one map any index."""

    def __init__(self, env: Any, grid: BlockGrid) -> None:
        super().__init__(env)
        self.grid = grid
        self._rng = np.random.default_rng()
        model = getattr(self.unwrapped, "model", None)
        if model is None or grid.names[0] not in {model.geom(geom).name for geom in range(model.ngeom)}:
            raise UserError(f"the model of {self.unwrapped} has no geom {grid.names[0]}; add the blocks by grid.add_to")

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Draw a map, write it into the model and reset the environment; `options={"map": 17}` takes that map.

        A seed starts the draws anew. The info has the index as `map`.
        """
        if seed is not None:
            self._rng = np.random.default_rng(seed)
        index = (options or {}).get("map", self._drawn())
        self.grid.write(self.unwrapped.model, build_many(self.grid.recipe, [index])[0])  # type: ignore[attr-defined]
        observation, info = self.env.reset(seed=seed, options=options)
        return observation, {**info, "map": index}

    def _drawn(self) -> int:
        recipe = self.grid.recipe
        if recipe.maps == 1:
            return int(self._rng.integers(SEEDS))
        return recipe.indices[int(self._rng.integers(recipe.maps))]
