"""The build sheet of the map that is shown."""

from __future__ import annotations

from PySide6.QtWidgets import QLabel, QVBoxLayout, QWidget

from rsegen.exporters.sheet import CutSettings, page_count
from rsegen.gui.job_dialog import JobDialog
from rsegen.gui.jobs import Sheet
from rsegen.gui.options_form import OptionsForm
from rsegen.gui.run_form import Words
from rsegen.recipe.recipe import Recipe

_WORDS = Words("sheet_folder", "sheets", "build sheet", "Write", "write the build sheet as PDF and CSV")


class SheetDialog(JobDialog):
    """With which saw, from which timber."""

    def __init__(self, recipe: Recipe, index: int, parent: QWidget | None = None) -> None:
        name = recipe.map_name(index)
        super().__init__("sheet_dialog", f"Build sheet of {name}", _WORDS, parent)
        self.setMinimumWidth(540)
        self._recipe = recipe.alone(index)
        self._saw = OptionsForm(CutSettings)
        pages = page_count(recipe)
        said = f"What to saw, and where each block stands: {name}.pdf ({pages} pages of A4) and {name}.csv"
        body = QWidget()
        column = QVBoxLayout(body)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(QLabel(said, wordWrap=True))
        column.addWidget(self._saw)
        self.lay_out(body)

    def job(self) -> Sheet:
        """The sheet by this saw."""
        return Sheet(recipe=self._recipe, folder=self.form.folder, saw=self._saw.made())
