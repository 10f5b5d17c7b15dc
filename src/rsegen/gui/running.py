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
    failed = Signal(str)

    def __init__(self, recipe: Recipe, folder: Path, *, force: bool) -> None:
        super().__init__()
        self._recipe, self._folder, self._force = recipe, folder, force
        self._done = 0

    def run(self) -> None:
        """In a thread of its own."""
        try:
            self.succeeded.emit(self._generated())
        except _Cancelled:
            self.failed.emit(f"cancelled: {self._done} of {self._recipe.maps} maps are in {self._folder}")
        except RsegenError as error:
            self.failed.emit(str(error))

    def _generated(self) -> str:
        made = generate(self._recipe, self._folder, force=self._force, progress=self._progress)
        warnings = dict.fromkeys(text for one in made.maps for text in one.warnings)
        said = [f"{len(made.maps)} map{'s'[: len(made.maps) > 1]} in {self._folder}, seed {made.recipe.seed}"]
        return "\n".join([*said, *(f"warning: {text}" for text in warnings)])

    def _progress(self, one: GeneratedMap) -> None:
        self._done += 1
        self.progressed.emit(self._done)
        if self.isInterruptionRequested():
            raise _Cancelled


class _Cancelled(Exception):
    """A person has had enough."""
