"""Many worlds of MuJoCo Warp with a map and a robot in each, for drives side by side.

A map has the same boxes as in `rsegen.mujoco.map_model`, so each world is the same as a `MujocoWorld`. All worlds of a
batch need the same number of boxes: the ones that a map lacks are deep below the ground, where no robot comes.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import inf
from typing import Any, ClassVar

import mujoco_warp as mjw
import numpy as np

from rsegen.field.stepfield import Array
from rsegen.geometry.box_merging import boxes
from rsegen.mujoco.many_worlds import ManyWorlds
from rsegen.mujoco.map_model import NamedBoxes
from rsegen.mujoco.settings import STEP
from rsegen.mujoco.turning import turn_gain
from rsegen.mujoco.world import SINKS, STARTS_IN, MujocoWorld, pose_numbers
from rsegen.recipe.recipe import Recipe
from rsegen.scene.scene import Scene, compose
from rsegen.simulators.batch import BatchWorlds
from rsegen.simulators.embedded import PlacedRobot

_UNUSED = (0.0, 0.0, -100.0), (0.01, 0.01, 0.01)
"""Centre and half of the sides, metres, of a box that a map lacks."""

_NO_ROOM = int(mjw.OverflowType.ALL & ~mjw.OverflowType.EPA_HORIZON)


class ManyMaps(BatchWorlds):
    """Worlds of maps of one friction, each with a robot of one kind at its start.

    many: the worlds; blocks: the numbers of the boxes' geoms
    """

    step_seconds: ClassVar[float] = STEP

    def __init__(self, scenes: Sequence[Scene], placed: Sequence[PlacedRobot], motors: str) -> None:
        maps = [boxes(scene.field) for scene in scenes]
        most = max(1, *map(len, maps))
        centres, halves = (np.tile(part, (len(maps), most, 1)) for part in _UNUSED)
        for index, filled in enumerate(maps):
            centres[index, : len(filled)], halves[index, : len(filled)] = filled.centres, filled.sizes / 2
        # One world is compiled, flat and with as many boxes as the largest map; then each world gets its own boxes.
        unused = (np.tile(part, (most, 1)) for part in _UNUSED)
        named = NamedBoxes("map", [f"block_{index}" for index in range(most)], *unused)
        flat = compose(Recipe(name="flat", boundary="none", friction=scenes[0].friction))
        gains = [turn_gain(placed[0].robot)]
        compiled = MujocoWorld(flat, placed[:1], motors=motors, period=inf, gains=gains, boxes=named)
        self.many = ManyWorlds(compiled, len(scenes))
        self.many.model.opt.warn_overflow = 0  # `problems` names them
        first = compiled.model.geom(named.names[0]).id
        self.blocks = slice(first, first + most)
        self.many.put_boxes(self.blocks, centres, halves)
        self.many.place([robot.start for robot in placed])
        self.many.find_contacts()
        self._sunk, self._deepest = "it was inside a block", STARTS_IN

    def poses(self) -> Array:
        """Return where robots are, (worlds, 6)."""
        return np.array([pose_numbers(state) for state in self.many.poses().tolist()])

    def drive(self, v: Array, w: Array) -> None:
        """Have robots drive at v, m/s forward, and w, rad/s counterclockwise, (worlds,)."""
        self.many.drive(v, w)

    def step(self, steps: int) -> None:
        """Simulate this number of steps in all worlds."""
        self.many.step(steps)
        self._sunk, self._deepest = "it sank in", SINKS

    def problems(self) -> Mapping[int, str]:
        """Return why worlds have no result: for the reasons of a single world, or too many contacts for the memory."""
        return dict(self._problems())

    def _problems(self) -> Iterator[tuple[int, str]]:
        data: Any = self.many.data
        has_room = (data.overflow.numpy() & _NO_ROOM) == 0
        is_finite = np.isfinite(data.qpos.numpy()).all(axis=-1)
        has_sunk = self.many.depths() > self._deepest
        for world in np.flatnonzero(~has_room | ~is_finite | has_sunk).tolist():
            if not is_finite[world]:
                yield world, "the physics failed"
            else:
                yield world, self._sunk if has_sunk[world] else "it had more contacts than there is room for"
