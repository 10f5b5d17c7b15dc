"""The dialog that shows many maps as a grid of pictures, sorted by any metric."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from math import inf, isnan

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QIcon, QImage, QPixmap
from PySide6.QtWidgets import (
    QComboBox,
    QDialog,
    QFormLayout,
    QLabel,
    QListView,
    QListWidget,
    QListWidgetItem,
    QProgressBar,
    QVBoxLayout,
    QWidget,
)

from rsegen.exporters.numbers import decimal
from rsegen.exporters.scene import compose
from rsegen.field.metrics.by_name import OF_A_ROBOT, UNITS, metric_by
from rsegen.field.metrics.custom import METRICS
from rsegen.gui.widgets.named import named
from rsegen.gui.widgets.plan_painting import square_image
from rsegen.gui.workers.latest_only import LatestOnly, failure_text
from rsegen.io.resources import refuse_too_large
from rsegen.recipe.recipe import Recipe

SIDE = 96
"""The side of a picture in pixels."""

MOST = 200
"""At most this many maps are shown; of more, some that are evenly spaced."""

_NUMBER = "number"

MapAt = Callable[[int], tuple[Recipe, int]]
"""The recipe of the map at a place, and its index in the recipe."""


class GalleryDialog(QDialog):
    """Shows the maps at the places 0 .. count - 1; `chosen` gives the place of one that was double clicked."""

    chosen = Signal(int)

    def __init__(self, title: str, count: int, map_at: MapAt, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        named(self, "gallery")
        self.setWindowTitle(title)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.resize(720, 560)
        self._map_at = map_at
        self._places = range(0, count, -(-count // MOST))
        self._items: dict[int, QListWidgetItem] = {}
        self._worker = LatestOnly(self)
        self._worker.result.connect(self._take)
        self._make_widgets(count)
        self._start()

    def done(self, result: int) -> None:
        """Stop drawing, and close."""
        self._worker.stop()
        super().done(result)

    def _make_widgets(self, count: int) -> None:
        tip = "maps are shown from the least to the greatest value"
        self._by = named(QComboBox(), "sort_by", title="sort by", tip=tip)
        self._by.addItems([_NUMBER, *(name for name in UNITS if name not in OF_A_ROBOT), *METRICS])
        self._by.currentIndexChanged.connect(self._start)
        self._maps = named(QListWidget(), "maps", tip="double click or Enter shows the map")
        self._maps.setViewMode(QListView.ViewMode.IconMode)
        self._maps.setResizeMode(QListView.ResizeMode.Adjust)
        self._maps.setMovement(QListView.Movement.Static)
        self._maps.setIconSize(QSize(SIDE, SIDE))
        self._maps.setGridSize(QSize(SIDE + 24, SIDE + 44))
        self._maps.setWordWrap(True)
        self._maps.itemActivated.connect(self._choose)
        self._bar, self._error = named(QProgressBar(), "progress"), named(QLabel(wordWrap=True), "gallery_error")
        self._bar.setRange(0, len(self._places))
        shown = (
            f"{len(self._places)} of {count:,} maps, evenly spaced" if len(self._places) < count else f"{count} maps"
        )
        form = QFormLayout()
        form.addRow("&Sort by", self._by)
        column = QVBoxLayout(self)
        column.addLayout(form)
        for widget in (self._maps, self._bar, self._error, QLabel(shown)):
            column.addWidget(widget)
        self._error.hide()

    def _start(self) -> None:
        """Look at all maps, one after the other."""
        self._values: dict[int, float] = {}
        self._error.hide()
        self._next()

    def _next(self) -> None:
        self._bar.setValue(len(self._values))
        self._bar.setVisible(len(self._values) < len(self._places))
        if len(self._values) == len(self._places):
            self._sort()
            return
        place = self._places[len(self._values)]
        self._worker.submit(partial(_look, self._by.currentText(), place, self._map_at, is_drawn=place in self._items))

    def _take(self, result: object) -> None:
        """Show a map, or why there are no more."""
        if not isinstance(result, tuple):
            self._error.setText(failure_text(result))
            self._error.show()
            self._bar.hide()
            return
        by, place, value, picture = result
        if by != self._by.currentText():
            return
        if isinstance(picture, QImage):
            self._items[place] = QListWidgetItem(QIcon(QPixmap.fromImage(picture)), "", self._maps)
            self._items[place].setData(Qt.ItemDataRole.UserRole, place)
        self._items[place].setText(f"map {place}" if by == _NUMBER else f"map {place}\n{_shown(by, value)}")
        self._values[place] = value
        self._next()

    def _sort(self) -> None:
        """Put the maps in the order of their values; those without a value last."""
        chosen = self._maps.currentItem()
        while self._maps.count():
            self._maps.takeItem(0)
        for place in sorted(self._values, key=lambda place: (_order(self._values[place]), place)):
            self._maps.addItem(self._items[place])
        self._maps.setCurrentItem(chosen or self._maps.item(0))

    def _choose(self, item: QListWidgetItem) -> None:
        self.accept()
        self.chosen.emit(item.data(Qt.ItemDataRole.UserRole))


def _look(by: str, place: int, map_at: MapAt, *, is_drawn: bool) -> tuple[str, int, float, QImage | None]:
    """The metric, the place, its value there, and a picture of the map unless it has one."""
    recipe, index = map_at(place)
    refuse_too_large(recipe)
    scene = compose(recipe, index)
    value = float(place) if by == _NUMBER else metric_by(by)(scene.field)
    return by, place, value, None if is_drawn else square_image(scene, SIDE)


def _shown(by: str, value: float) -> str:
    unit = metric_by(by).unit
    if isnan(value):
        return "-"
    return f"{decimal(round(value * 100, 2))} cm" if unit == "m" else f"{value:.4g} {unit}".strip()


def _order(value: float) -> float:
    return inf if isnan(value) else value
