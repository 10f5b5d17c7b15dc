"""The dialogs of opening: examples as pictures, how to read heights, and where to save a file."""

from __future__ import annotations

import re
from pathlib import Path

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QFileDialog,
    QLabel,
    QListView,
    QListWidget,
    QListWidgetItem,
    QVBoxLayout,
    QWidget,
)

from rsegen.errors import RsegenError
from rsegen.exporters.scene import compose
from rsegen.gui.widgets.editors import TextEditor
from rsegen.gui.widgets.layouts import MessageLabel, named
from rsegen.gui.widgets.plan_painting import square_icon
from rsegen.gui.widgets.run_form import OptionsForm, may_replace
from rsegen.io.importers import imported, importer_for
from rsegen.io.recipe_file import load
from rsegen.params.registry import summary
from rsegen.params.sorts import parameters
from rsegen.recipe.examples import EXAMPLES
from rsegen.recipe.recipe import Recipe

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


class HeightsDialog(QDialog):
    """Asks for a format's options; `recipe` is the result, None unless accepted."""

    def __init__(self, parent: QWidget, path: Path) -> None:
        super().__init__(parent)
        named(self, "heights_dialog")
        self.setWindowTitle(f"Read heights from {path.name}")
        self.recipe: Recipe | None = None
        self._path, self._format = path, importer_for(path)
        self._options = OptionsForm(self._format)
        self._unit = TextEditor("unit_cm", parameters(Recipe)["unit_cm"])
        self._options.add(self._unit, "Unit in cm (default: as in the file)")
        self._error_label = MessageLabel("heights_error")
        self._lay_out()

    def accept(self) -> None:
        """Read the file, or show what is wrong."""
        try:
            unit = self._unit.value()
            checked = None if unit is None else self._unit.parameter.check("unit_cm", unit)
            self.recipe = imported(self._path, self._options.value(), checked)
        except RsegenError as error:
            self._error_label.show_message(str(error))
            return
        super().accept()

    def _lay_out(self) -> None:
        about = QLabel(summary(self._format), wordWrap=True)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Ok | QDialogButtonBox.StandardButton.Cancel)
        buttons.accepted.connect(self.accept)
        buttons.rejected.connect(self.reject)
        column = QVBoxLayout(self)
        column.addWidget(about)
        column.addWidget(self._options)
        column.addWidget(self._error_label)
        column.addWidget(buttons)


def ask_where_to_save(parent: QWidget, title: str, default: str, formats: str) -> Path | None:
    """The file that the user chooses, with a suffix of the formats; None if the user cancels.

    formats: as in Qt, such as `PNG (*.png);;JPEG (*.jpg *.jpeg)`.
    """
    name, chosen = QFileDialog.getSaveFileName(parent, title, default, formats)
    if not name:
        return None
    path = Path(name)
    if path.suffix.lower() in _suffixes(formats):
        return path
    path = path.with_name(path.name + _suffixes(chosen or formats)[0])
    if path.exists() and not may_replace(parent, f"{path.name} already exists. Replace it?"):
        return None  # Qt has asked for the name without the suffix only
    return path


def _suffixes(formats: str) -> list[str]:
    return re.findall(r"\*(\.\w+)", formats)
