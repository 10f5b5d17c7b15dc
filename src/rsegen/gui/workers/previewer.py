"""The preview of a map, computed in a thread if the map is large, and then its costs."""

from __future__ import annotations

from functools import partial

from PySide6.QtCore import QObject, Signal

from rsegen.exporters.scene import Scene
from rsegen.gui.model.map_numbers import Costs, costs
from rsegen.gui.model.preview import Preview, is_quick, preview
from rsegen.gui.model.session import Entry
from rsegen.gui.workers.latest_only import LatestOnly, failure_text
from rsegen.recipe.recipe import Recipe


class Previewer(QObject):
    """Computes previews, of which only the latest counts.

    previewed: its Preview; counted: its Costs; failed: why there is no preview.
    """

    previewed = Signal(object)
    counted = Signal(object)
    failed = Signal(str)

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self._shown: Preview | None = None
        self._previews, self._counts = LatestOnly(self), LatestOnly(self)
        self._previews.result.connect(self._take_preview)
        self._counts.result.connect(self._take_costs)

    @property
    def scene(self) -> Scene | None:
        """The scene that was previewed last."""
        return self._shown.scene if self._shown else None

    @property
    def busy(self) -> bool:
        """Whether a preview is being computed in the thread."""
        return self._previews.busy

    def preview(self, recipe: Recipe, index: int, proposed: Entry | None = None) -> None:
        """Preview one map of a recipe, with a ghost of one more obstacle; a small map at once."""
        self._previews.submit(partial(preview, recipe, index, proposed, self._shown), at_once=is_quick(recipe))

    def count(self, robot: str) -> None:
        """Count the costs of the scene, and whether a robot can cross it if one is named."""
        if self.scene:
            self._counts.submit(partial(costs, self.scene, robot))

    def stop(self) -> None:
        """Wait for what is being computed, and discard it."""
        self._previews.stop()
        self._counts.stop()

    def _take_preview(self, result: object) -> None:
        if isinstance(result, Preview):
            self._shown = result
            self.previewed.emit(result)
        else:
            self.failed.emit(failure_text(result))

    def _take_costs(self, result: object) -> None:
        if isinstance(result, Costs):
            self.counted.emit(result)
