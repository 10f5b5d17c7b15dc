"""The dialog that is open while a picture is drawn and written."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtGui import QImage
from PySide6.QtWidgets import QMessageBox, QProgressDialog, QWidget

from rsegen.gui.widgets.named import named
from rsegen.gui.workers.picture_saver import PictureSaver


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
