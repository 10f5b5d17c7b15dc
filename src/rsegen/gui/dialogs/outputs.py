"""The dialogs of outputs: build sheet, code, export formats, size of a picture, and saving it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QFontDatabase, QGuiApplication, QImage
from PySide6.QtWidgets import (
    QCheckBox,
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QLabel,
    QMessageBox,
    QPlainTextEdit,
    QProgressDialog,
    QPushButton,
    QScrollArea,
    QVBoxLayout,
    QWidget,
)

from rsegen.exporters.sheet import CutSettings, page_count
from rsegen.gui.dialogs.job import JobDialog
from rsegen.gui.model.as_code import command_line, python_code
from rsegen.gui.model.jobs import ExportJob, SheetJob, WorldsJob
from rsegen.gui.widgets.editors import IntegerBox
from rsegen.gui.widgets.layouts import named, row_of
from rsegen.gui.widgets.run_form import FormatList, FormTexts, OptionsForm
from rsegen.gui.workers import PictureSaver
from rsegen.recipe.recipe import Recipe

_SHEET_TEXTS = FormTexts("sheet_folder", "sheets", "build sheet", "Write", "write the build sheet as PDF and CSV")


class SheetDialog(JobDialog):
    """Asks for the saw and the timber."""

    def __init__(self, recipe: Recipe, index: int, parent: QWidget | None = None) -> None:
        name = recipe.map_name(index)
        super().__init__("sheet_dialog", f"Build sheet of {name}", _SHEET_TEXTS, parent)
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


class CodeDialog(QDialog):
    """The command line and the Python code that write the same maps as Start."""

    def __init__(self, job: WorldsJob, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        named(self, "code_dialog")
        self.setWindowTitle("Command line and Python code")
        self.resize(760, 560)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        column = QVBoxLayout(self)
        for title, name, text, share in (
            ("Command line", "command_line", command_line(job.recipe, str(job.folder), sheets=job.sheets), 2),
            ("Python code", "python_code", python_code(job.recipe, str(job.folder), sheets=job.sheets), 5),
        ):
            page = _page(name, text)
            copy = named(QPushButton("Copy"), f"copy_{name}", title=f"copy the {title}", tip="copy the whole text")
            copy.setAutoDefault(False)
            copy.clicked.connect(lambda _=False, text=text: QGuiApplication.clipboard().setText(text))
            head = row_of(QLabel(title), copy)
            head.insertStretch(1, 1)
            column.addLayout(head)
            column.addWidget(page, stretch=share)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        buttons.rejected.connect(self.reject)
        column.addWidget(buttons)


def _page(name: str, text: str) -> QPlainTextEdit:
    """A read-only text in a monospaced font."""
    page = named(QPlainTextEdit(text), name)
    page.setReadOnly(True)
    page.setTabChangesFocus(True)
    page.setFont(QFontDatabase.systemFont(QFontDatabase.SystemFont.FixedFont))
    page.setMinimumHeight(5 * page.fontMetrics().lineSpacing())
    return page


_EXPORT_TEXTS = FormTexts(
    "export_folder", "exported", "maps", "Export", "write the maps in the formats that are ticked"
)


class ExportDialog(JobDialog):
    """Asks for formats, and for all maps or the one that is shown."""

    def __init__(self, recipe: Recipe, index: int, parent: QWidget | None = None) -> None:
        super().__init__("export_dialog", "Export for other programs", _EXPORT_TEXTS, parent)
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


_MOST = 8192
"""Pixels a side that OpenGL draws at once."""


class PictureSizeDialog(QDialog):
    """Asks for width and height, twice those of the view by default."""

    def __init__(self, view: QSize, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("picture_size_dialog")
        self.setWindowTitle("Save the picture")
        tip = "of the picture; texts and lines grow with its height"
        self._width, self._height = (
            named(IntegerBox(suffix=" pixels"), name, tip=tip) for name in ("picture_width", "picture_height")
        )
        for box, side in ((self._width, view.width()), (self._height, view.height())):
            box.setRange(16, _MOST)
            box.setValue(2 * side)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Save | QDialogButtonBox.StandardButton.Cancel)
        buttons.accepted.connect(self.accept)
        buttons.rejected.connect(self.reject)
        form = QFormLayout(self)
        form.addRow("&Width", self._width)
        form.addRow("&Height", self._height)
        form.addRow(buttons)

    @property
    def size_in_pixels(self) -> QSize:
        """The size in the fields."""
        return QSize(self._width.value(), self._height.value())


class SavingDialog(QProgressDialog):
    """Saves a picture, and closes when it is written; Cancel closes it at once, and no file is written."""

    def __init__(self, saver: PictureSaver, draw: Callable[[], QImage], path: Path, parent: QWidget) -> None:
        super().__init__(f"Saving {path.name}...", "Cancel", 0, 0, parent)
        named(self, "saving_dialog")
        self.setWindowTitle("Save the picture")
        self.setWindowModality(Qt.WindowModality.WindowModal)
        self._saver = saver
        self.canceled.connect(self._cancel)
        saver.ended.connect(self._end)
        self.open()
        saver.save(draw, path)

    def _cancel(self) -> None:
        self._saver.cancel()
        self._leave()

    def _leave(self) -> None:
        self._saver.ended.disconnect(self._end)
        self.hide()
        self.deleteLater()

    def _end(self, problem: str) -> None:
        parent = self.parentWidget()
        self._leave()
        if problem:
            QMessageBox.warning(parent, "rsegen", problem)
