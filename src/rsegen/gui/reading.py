"""Asking how a file of heights is to be read: the options of its format, and the unit."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtWidgets import QDialog, QDialogButtonBox, QLabel, QVBoxLayout, QWidget

from rsegen.errors import RsegenError
from rsegen.gui.editors import TextEditor, named
from rsegen.gui.notice import Notice
from rsegen.gui.options_form import OptionsForm
from rsegen.io.importers import imported, importer_for
from rsegen.params.sorts import parameters
from rsegen.recipe.recipe import Recipe


class Reading(QDialog):
    """A form of a format's options; `recipe` is there once it is accepted."""

    def __init__(self, parent: QWidget, path: Path) -> None:
        super().__init__(parent)
        named(self, "reading")
        self.setWindowTitle(f"Read heights from {path.name}")
        self.recipe: Recipe | None = None
        self._path, self._format = path, importer_for(path)
        self._options = OptionsForm(self._format)
        self._unit = TextEditor("unit_cm", parameters(Recipe)["unit_cm"])
        self._options.add(self._unit, "Unit in cm (else as in the file)")
        self._complaint = Notice("reading_complaint")
        self._lay_out()

    def accept(self) -> None:
        """Read it; what is wrong is said here."""
        try:
            unit = self._unit.value()
            checked = None if unit is None else self._unit.parameter.check("unit_cm", unit)
            self.recipe = imported(self._path, self._options.made(), checked)
        except RsegenError as error:
            self._complaint.say(str(error))
            return
        super().accept()

    def _lay_out(self) -> None:
        said = QLabel((self._format.__doc__ or "").splitlines()[0], wordWrap=True)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Ok | QDialogButtonBox.StandardButton.Cancel)
        buttons.accepted.connect(self.accept)
        buttons.rejected.connect(self.reject)
        column = QVBoxLayout(self)
        column.addWidget(said)
        column.addWidget(self._options)
        column.addWidget(self._complaint)
        column.addWidget(buttons)
