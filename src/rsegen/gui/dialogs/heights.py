"""The dialog that asks how to read a file of heights: the options of its format, and the unit."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtWidgets import QDialog, QDialogButtonBox, QLabel, QVBoxLayout, QWidget

from rsegen.errors import RsegenError
from rsegen.gui.widgets.editors import TextEditor
from rsegen.gui.widgets.message_label import MessageLabel
from rsegen.gui.widgets.named import named
from rsegen.gui.widgets.options_form import OptionsForm
from rsegen.io.importers import imported, importer_for
from rsegen.params.registry import summary
from rsegen.params.sorts import parameters
from rsegen.recipe.recipe import Recipe


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
