"""The dialogs that show many maps as a grid of pictures, and a map of a data set."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from math import inf, isnan
from pathlib import Path

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QIcon, QImage, QPixmap
from PySide6.QtWidgets import (
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QFrame,
    QHBoxLayout,
    QLabel,
    QListView,
    QListWidget,
    QListWidgetItem,
    QProgressBar,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from rsegen.exporters.numbers import decimal
from rsegen.exporters.scene import compose
from rsegen.field.metrics.catalogue import METRICS, OF_A_ROBOT, UNITS, metric_by
from rsegen.gui.widgets.editors import IntegerBox
from rsegen.gui.widgets.layouts import named
from rsegen.gui.widgets.plan_painting import square_image
from rsegen.gui.workers import LatestOnly, failure_text
from rsegen.io.dataset.layout import read_manifest
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


PICTURE_SIDE = 200
"""The side of the picture in pixels."""

_MOST = 2**31 - 1


class DatasetDialog(QDialog):
    """Asks for the number of a map; `chosen` gives DIR#NUMBER. A UserError if the folder has no data set."""

    chosen = Signal(Path)

    def __init__(self, folder: Path, parent: QWidget | None = None) -> None:
        layout = read_manifest(folder)[0]
        super().__init__(parent)
        named(self, "dataset_dialog")
        self.setWindowTitle("Open a map of a data set")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._folder, self._layout = folder, layout
        self._number = named(IntegerBox(), "place", title="map", tip="maps are counted from 0, as in DIR#17")
        self._number.setRange(0, min(layout.maps - 1, _MOST))
        self._picture = named(QLabel(alignment=Qt.AlignmentFlag.AlignCenter, wordWrap=True), "picture")
        self._picture.setFixedSize(PICTURE_SIDE, PICTURE_SIDE)
        self._worker = LatestOnly(self)
        self._worker.result.connect(self._show)
        self._number.valueChanged.connect(self._draw)
        self._lay_out()
        self._draw()

    def accept(self) -> None:
        """Emit the map that was chosen."""
        super().accept()
        self.chosen.emit(Path(f"{self._folder}#{self._number.value()}"))

    def done(self, result: int) -> None:
        """Stop drawing, and close."""
        self._worker.stop()
        super().done(result)

    def _lay_out(self) -> None:
        standard = QDialogButtonBox.StandardButton
        buttons = QDialogButtonBox(standard.Open | standard.Cancel)
        buttons.accepted.connect(self.accept)
        buttons.rejected.connect(self.reject)
        tip = "all maps as pictures, sorted by any metric"
        everything = named(QPushButton("All maps..."), "all_maps", title="all maps", tip=tip)
        buttons.addButton(everything, QDialogButtonBox.ButtonRole.ActionRole)
        everything.clicked.connect(self._show_all)
        above = QHBoxLayout()
        above.addWidget(self._picture)
        above.addSpacing(12)
        above.addLayout(self._description(), stretch=1)
        column = QVBoxLayout(self)
        column.addLayout(above)
        column.addWidget(_line())
        column.addWidget(buttons)
        self._number.selectAll()
        self._number.setFocus()

    def _show_all(self) -> None:
        dialog = GalleryDialog(f"Maps of {self._folder.name}", self._layout.maps, self._layout.map_at, self)
        dialog.chosen.connect(self._number.setValue)
        dialog.open()

    def _description(self) -> QVBoxLayout:
        """The folder, size and seed of the data set, and the field for the number."""
        maps, (n_x, n_y) = self._layout.maps, self._layout.grid_shape
        first, *others = self._layout.recipes
        of = f"{len(others) + 1} recipes" if others else f"seed {first.seed}"
        folder = QLabel(self._folder.name or str(self._folder), textFormat=Qt.TextFormat.PlainText)
        folder.setToolTip(str(self._folder))
        font = folder.font()
        font.setBold(True)
        folder.setFont(font)
        form = QFormLayout()
        form.addRow(f"&Map, 0 to {maps - 1}", self._number)
        column = QVBoxLayout()
        for label in (folder, QLabel(f"{maps:,} maps of {n_x} x {n_y} blocks\n{of}")):
            column.addWidget(label)
        column.addSpacing(12)
        column.addLayout(form)
        column.addStretch(1)
        return column

    def _draw(self) -> None:
        recipe, index = self._layout.map_at(self._number.value())

        def drawn() -> QImage:
            refuse_too_large(recipe)
            return square_image(compose(recipe, index), PICTURE_SIDE)

        self._worker.submit(drawn)

    def _show(self, result: object) -> None:
        """Show the picture, or why there is none."""
        if isinstance(result, QImage):
            self._picture.setPixmap(QPixmap.fromImage(result))
        else:
            self._picture.setText(failure_text(result))


def _line() -> QFrame:
    return QFrame(frameShape=QFrame.Shape.HLine, frameShadow=QFrame.Shadow.Sunken)
