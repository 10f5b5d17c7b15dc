"""Sending the map that is shown to the simulation that runs, in the place of the one that was sent before."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from itertools import count
from pathlib import Path

from PySide6.QtCore import QObject, Signal

from rsegen.gui.newest import Newest
from rsegen.recipe.recipe import Recipe
from rsegen.simulation.simulators.connecting import connected
from rsegen.simulation.simulators.live_world import Pose
from rsegen.simulation.spawning.map_models import map_model
from rsegen.simulation.spawning.spawned_map import SpawnedMap
from rsegen.simulation.spawning.spawning import at_free_place, spawn_map

_ORIGIN = Pose(x=0, y=0, z=0)


class Sending(QObject):
    """`told` says what came of it. Each map has a folder and a name of its own: simulators keep meshes by path."""

    told = Signal(str)

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self._folder = tempfile.TemporaryDirectory(prefix="rsegen-", ignore_cleanup_errors=True)
        self._numbers = count(1)
        self._before: SpawnedMap | None = None
        self._work = Newest(self)
        self._work.came.connect(self._came)

    def send(self, recipe: Recipe, index: int) -> None:
        """Send one map of a recipe, behind the window."""
        number, before = next(self._numbers), self._before
        self.told.emit(f"Sending {recipe.map_name(index)}...")
        self._work.order(lambda: _sent(recipe.alone(index), Path(self._folder.name, str(number)), number, before))

    def end(self) -> None:
        """Forget what was written."""
        self._work.end()
        self._folder.cleanup()

    def _came(self, came: object) -> None:
        if isinstance(came, SpawnedMap):
            self._before = came
            self.told.emit(f"{came.name} is in the simulation")
        else:
            self.told.emit(str(came))


def _sent(recipe: Recipe, folder: Path, number: int, before: SpawnedMap | None) -> SpawnedMap:
    """The map as it stands there: where the one before stands, or else at the free place nearest to the origin."""
    one = map_model(recipe, recipe.first_map, folder)
    with connected(None) as (simulator, live):
        one.check_fits(simulator)
        poses = live.poses()
        old = replace(before, at=poses[before.name]) if before and before.name in poses else None
        new = SpawnedMap(name=f"{one.name}-{number}", field=one.field, at=old.at if old else _ORIGIN)
        new = new if old else at_free_place(new, poses, [])
        spawn_map(live, one.sdf(new.name), new, old)
    return new
