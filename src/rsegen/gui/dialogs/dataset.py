"""The dialog that asks which map of a data set to open, and shows its picture."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QImage, QPixmap
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QFrame,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from rsegen.exporters.scene import compose
from rsegen.gui.dialogs.gallery import GalleryDialog
from rsegen.gui.widgets.named import named
from rsegen.gui.widgets.number_boxes import IntegerBox
from rsegen.gui.widgets.plan_painting import square_image
from rsegen.gui.workers.latest_only import LatestOnly, failure_text
from rsegen.io.dataset.manifest import read_manifest
from rsegen.io.resources import refuse_too_large

SIDE = 200
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
        self._picture.setFixedSize(SIDE, SIDE)
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
            return square_image(compose(recipe, index), SIDE)

        self._worker.submit(drawn)

    def _show(self, result: object) -> None:
        """Show the picture, or why there is none."""
        if isinstance(result, QImage):
            self._picture.setPixmap(QPixmap.fromImage(result))
        else:
            self._picture.setText(failure_text(result))


def _line() -> QFrame:
    return QFrame(frameShape=QFrame.Shape.HLine, frameShadow=QFrame.Shadow.Sunken)
