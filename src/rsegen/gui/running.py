"""Generating behind the window: it never freezes, and can be cancelled between maps."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QThread, Signal

from rsegen.errors import RsegenError
from rsegen.pipeline import GeneratedMap, generate
from rsegen.recipe import Recipe


class Generation(QThread):
    """One run of `generate`: `progressed` counts maps, the others tell what came of it."""

    progressed = Signal(int)
    succeeded = Signal(str)
    cancelled = Signal(str)
    failed = Signal(str)

    def __init__(self, recipe: Recipe, folder: Path, *, force: bool) -> None:
        super().__init__()
        self.folder = folder
        self._recipe, self._force = recipe, force
        self._done = 0

    def run(self) -> None:
        """In a thread of its own."""
        try:
            self.succeeded.emit(self._generated())
        except _Cancelled:
            self.cancelled.emit(f"Cancelled: {self._done} of {self._recipe.maps} maps are in {self.folder}")
        except RsegenError as error:
            self.failed.emit(str(error))

    def _generated(self) -> str:
        made = generate(self._recipe, self.folder, force=self._force, progress=self._progress)
        return f"{len(made.maps)} map{'s'[: len(made.maps) > 1]} in {self.folder}, seed {made.recipe.seed}"

    def _progress(self, one: GeneratedMap) -> None:
        self._done += 1
        self.progressed.emit(self._done)
        if self.isInterruptionRequested():
            raise _Cancelled


class _Cancelled(Exception):
    """A person has had enough."""
