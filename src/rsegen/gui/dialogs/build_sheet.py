"""The dialog that writes the build sheet of the map that is shown."""

from __future__ import annotations

from PySide6.QtWidgets import QLabel, QVBoxLayout, QWidget

from rsegen.exporters.sheet import CutSettings, page_count
from rsegen.gui.dialogs.job import JobDialog
from rsegen.gui.model.jobs import SheetJob
from rsegen.gui.widgets.options_form import OptionsForm
from rsegen.gui.widgets.run_form import FormTexts
from rsegen.recipe.recipe import Recipe

_TEXTS = FormTexts("sheet_folder", "sheets", "build sheet", "Write", "write the build sheet as PDF and CSV")


class SheetDialog(JobDialog):
    """Asks for the saw and the timber."""

    def __init__(self, recipe: Recipe, index: int, parent: QWidget | None = None) -> None:
        name = recipe.map_name(index)
        super().__init__("sheet_dialog", f"Build sheet of {name}", _TEXTS, parent)
        self.setMinimumWidth(540)
        self._recipe = recipe.alone(index)
        self._saw = OptionsForm(CutSettings, CutSettings.default(recipe.units))
        pages = page_count(recipe)
        about = f"The cutting list, and the place of each block: {name}.pdf ({pages} pages of A4) and {name}.csv"
        body = QWidget()
        column = QVBoxLayout(body)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(QLabel(about, wordWrap=True))
        column.addWidget(self._saw)
        self.lay_out(body)

    def job(self) -> SheetJob:
        """The build sheet for this saw and timber."""
        return SheetJob(recipe=self._recipe, folder=self.form.folder, saw=self._saw.value())
