"""The dialog that shows the examples as pictures, to start from one."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QLabel,
    QListView,
    QListWidget,
    QListWidgetItem,
    QVBoxLayout,
    QWidget,
)

from rsegen.exporters.scene import compose
from rsegen.gui.widgets.named import named
from rsegen.gui.widgets.plan_painting import square_icon
from rsegen.io.recipe_file import load
from rsegen.recipe.examples import EXAMPLES

SIDE = 150
"""The side of a picture in pixels."""


class ExampleDialog(QDialog):
    """A picture and a name per example; `chosen` gives the file of the one that is opened."""

    chosen = Signal(Path)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        named(self, "example_dialog")
        self.setWindowTitle("New from example")
        self.resize(720, 460)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._list = _pictures()
        self._about = named(QLabel(wordWrap=True), "about")
        standard = QDialogButtonBox.StandardButton
        buttons = QDialogButtonBox(standard.Open | standard.Cancel)
        column = QVBoxLayout(self)
        for widget in (self._list, self._about, buttons):
            column.addWidget(widget)
        self._list.currentItemChanged.connect(self._describe)
        self._list.itemActivated.connect(self._choose)
        buttons.accepted.connect(self._choose)
        buttons.rejected.connect(self.reject)
        self._fill()

    def _fill(self) -> None:
        for path in EXAMPLES.values():
            recipe = load(path)
            item = QListWidgetItem(square_icon(compose(recipe, recipe.first_map), SIDE), recipe.name, self._list)
            item.setToolTip(recipe.description)
            item.setData(Qt.ItemDataRole.UserRole, path)
            item.setData(Qt.ItemDataRole.AccessibleDescriptionRole, recipe.description)
        self._list.setCurrentRow(0)

    def _describe(self, item: QListWidgetItem) -> None:
        self._about.setText(item.toolTip())

    def _choose(self) -> None:
        self.accept()
        self.chosen.emit(self._list.currentItem().data(Qt.ItemDataRole.UserRole))


def _pictures() -> QListWidget:
    """An empty list that shows its items as pictures in a grid."""
    found = named(QListWidget(), "examples", tip="double click or Enter opens a copy")
    found.setViewMode(QListView.ViewMode.IconMode)
    found.setResizeMode(QListView.ResizeMode.Adjust)
    found.setMovement(QListView.Movement.Static)
    found.setIconSize(QSize(SIDE, SIDE))
    found.setGridSize(QSize(SIDE + 20, SIDE + 30))
    return found
