"""The dialog that exports maps in formats of other programs."""

from __future__ import annotations

from PySide6.QtWidgets import QCheckBox, QScrollArea, QVBoxLayout, QWidget

from rsegen.gui.dialogs.job import JobDialog
from rsegen.gui.model.jobs import ExportJob
from rsegen.gui.widgets.format_list import FormatList
from rsegen.gui.widgets.named import named
from rsegen.gui.widgets.run_form import FormTexts
from rsegen.recipe.recipe import Recipe

_TEXTS = FormTexts("export_folder", "exported", "maps", "Export", "write the maps in the formats that are ticked")


class ExportDialog(JobDialog):
    """Asks for formats, and for all maps or the one that is shown."""

    def __init__(self, recipe: Recipe, index: int, parent: QWidget | None = None) -> None:
        super().__init__("export_dialog", "Export for other programs", _TEXTS, parent)
        self.resize(900, 620)
        self._recipe, self._index = recipe, index
        self._formats = FormatList()
        self._formats.changed.connect(self.show_state)
        tip = "otherwise all maps of the recipe"
        self._alone = named(QCheckBox(f"Only map {index}, which is shown"), "alone", tip=tip)
        self._alone.setVisible(recipe.maps > 1)
        self.lay_out(self._framed(), stretch=1)
        self.show_state()

    def job(self) -> ExportJob:
        """The export of the maps in the formats that are ticked."""
        recipe = self._recipe.alone(self._index) if self._alone.isChecked() else self._recipe
        return ExportJob(recipe=recipe, folder=self.form.folder, formats=self._formats.formats())

    def show_state(self) -> None:
        """Enable Export if any format is ticked."""
        super().show_state()
        self.form.start.setEnabled(self._formats.any_ticked())

    def _framed(self) -> QWidget:
        """The formats in a scroll area."""
        area = QScrollArea(widgetResizable=True)
        area.setWidget(self._formats)
        body = QWidget()
        column = QVBoxLayout(body)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(area)
        column.addWidget(self._alone)
        return body
