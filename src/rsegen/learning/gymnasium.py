"""Gymnasium: a wrapper that gives an environment of MuJoCo a new field at each reset.

    env = NewFieldAtReset(gymnasium.make("Ant-v5", xml_file="./ant_on_blocks.xml"), grid)
    observation, info = env.reset(seed=7)    # info["map"] is the index of the map
    env.ground.heights(env.unwrapped.data.qpos[:2])

The model has the blocks of the grid: `grid.add_to(spec)`.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import gymnasium
import numpy as np

from rsegen.errors import UserError, refuse_other
from rsegen.field.stepfield import Array, Levels
from rsegen.learning.ground import Ground
from rsegen.learning.mujoco import BlockGrid
from rsegen.learning.seating import CLEARANCE, Seats
from rsegen.params.sorts import Integer
from rsegen.params.streams import SEEDS
from rsegen.recipe.batch import build_many
from rsegen.recipe.recipe import Recipe

_AHEAD = 64
"""Maps that are made together: `build_many` makes dozens of small maps in little more than the time of one."""

_INDEX = Integer(0, SEEDS - 1)


class MapDraws:
    """Maps of a recipe as chance draws them: of a recipe of one map any index, of several one of its own."""

    def __init__(self, recipe: Recipe, rng: np.random.Generator) -> None:
        self._recipe, self._rng = recipe, rng
        self._drawn: list[tuple[int, Levels]] = []

    def next(self, options: dict[str, Any] | None = None) -> tuple[int, Levels]:
        """Return the index and the levels of the next map, or of the `map` in the options of a reset."""
        if options and "map" in options:
            index = _INDEX.check("options['map']", options["map"])
            return index, build_many(self._recipe, [index])[0]
        if not self._drawn:  # many are drawn and made together
            recipe = self._recipe
            draws = self._rng.integers(SEEDS if recipe.maps == 1 else recipe.maps, size=_AHEAD).tolist()
            indices = draws if recipe.maps == 1 else [recipe.indices[draw] for draw in draws]
            self._drawn = list(zip(indices, build_many(recipe, indices), strict=True))[::-1]  # taken from the end
        return self._drawn.pop()


class NewFieldAtReset(gymnasium.Wrapper[Any, Any, Any, Any], gymnasium.utils.RecordConstructorArgs):
    """Draws a map of the grid's recipe at each reset, by the seed of the resets; of a recipe of one map any index.

    An environment of Gymnasium's MujocoEnv starts above the blocks: each body that can rise is raised until none of its
    geoms is in the ground, and the observation is the one after that; UserError if it starts in the ground without
    `set_state`, by which it is raised. Other environments place their robots themselves; `ground` is the map as it is
    now, such as `ground.lift(feet)`.
    """

    def __init__(self, env: Any, grid: BlockGrid) -> None:
        gymnasium.utils.RecordConstructorArgs.__init__(self, grid=grid)
        gymnasium.Wrapper.__init__(self, env)
        self.grid = grid
        model = getattr(self.unwrapped, "model", None)
        refuse_other("grid", grid, BlockGrid)
        if model is None:
            raise UserError(f"{self.unwrapped} has no model of MuJoCo; use one of Gymnasium's MujocoEnv")
        grid.geoms(model)  # refuses a model without the blocks
        self._draws = MapDraws(grid.recipe, np.random.default_rng())
        self.ground: Ground = grid.ground(grid.highest)
        self._seats = Seats(model)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Draw a map, write it into the model and reset the environment; `options={"map": 17}` takes that map.

        A seed starts the draws anew. The info has the index as `map`.
        """
        if seed is not None:
            self._draws = MapDraws(self.grid.recipe, np.random.default_rng(seed))
        index, levels = self._draws.next(options)
        # The seats have a copy of the model, in which they look for contacts.
        for model in (self.unwrapped.model, self._seats.model):  # type: ignore[attr-defined]
            self.grid.write(model, levels)
        self.ground.write(levels)
        with self._robots_above_the_blocks():
            observation, info = self.env.reset(seed=seed, options=options)
        return observation, {**info, "map": index}

    @contextmanager
    def _robots_above_the_blocks(self) -> Iterator[None]:
        """Raise the state in which a MujocoEnv starts: what it observes after `set_state` is then right."""
        env: Any = self.unwrapped
        if not hasattr(env, "set_state"):
            yield
            return
        # A reset of MujocoEnv draws a state, and hands it to `set_state` before it observes.
        own, is_raised = env.set_state, False

        def set_state(qpos: Array, qvel: Array) -> None:
            nonlocal is_raised
            is_raised = True
            own(self._seats.put(qpos, self.ground, lower=False), qvel)

        env.set_state = set_state
        try:
            yield
        finally:
            del env.set_state
        if not is_raised and self._seats.rise(env.data.qpos, self.ground) > CLEARANCE:
            raise UserError(f"{env} starts in the blocks: call set_state in its reset_model, by which it is raised")
