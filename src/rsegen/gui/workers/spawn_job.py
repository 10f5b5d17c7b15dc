"""Spawning the map that is shown in the running simulation, in place of the one spawned before."""

from __future__ import annotations

import tempfile
from itertools import count
from pathlib import Path

from PySide6.QtCore import QObject, Signal

from rsegen.gui.model.simulation import SpawnedMap, Spawning, spawn
from rsegen.gui.workers.latest_only import LatestOnly, failure_text
from rsegen.recipe.recipe import Recipe


class SpawnJob(QObject):
    """Spawns maps in a thread; `message` says what is done and how it ended.

    Each map has a folder and a name of its own, since simulators cache meshes by path.
    """

    message = Signal(str)

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self._folder = tempfile.TemporaryDirectory(prefix="rsegen-", ignore_cleanup_errors=True)
        self._numbers = count(1)
        self._before: SpawnedMap | None = None
        self._worker = LatestOnly(self)
        self._worker.result.connect(self._spawned)

    def spawn(self, recipe: Recipe, index: int) -> None:
        """Spawn one map of a recipe."""
        number, before = next(self._numbers), self._before
        self.message.emit(f"Spawning {recipe.map_name(index)}...")
        self._worker.submit(lambda: spawn(recipe.alone(index), Path(self._folder.name, str(number)), number, before))

    def stop(self) -> None:
        """Wait for the map that is being spawned, and delete what was written."""
        self._worker.stop()
        self._folder.cleanup()

    def _spawned(self, result: object) -> None:
        if isinstance(result, Spawning):
            self._before = result.spawned
            instead = f", in place of {result.replaced}" if result.replaced else ""
            self.message.emit(f"{result.spawned.name} is in the simulation{instead}")
        else:
            self.message.emit(failure_text(result))
