"""The dialog that asks for the size of a picture in pixels."""

from __future__ import annotations

from PySide6.QtCore import QSize
from PySide6.QtWidgets import QDialog, QDialogButtonBox, QFormLayout, QWidget

from rsegen.gui.widgets.named import named
from rsegen.gui.widgets.number_boxes import IntegerBox

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
