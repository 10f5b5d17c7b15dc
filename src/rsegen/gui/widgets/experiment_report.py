"""The table and the plot of an experiment, each on a tab."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtGui import QPixmap, QResizeEvent
from PySide6.QtWidgets import QLabel, QSizePolicy, QTabWidget, QTextBrowser

from rsegen.gui.widgets.named import named


class ExperimentReport(QTabWidget):
    """Shows the files of an experiment."""

    def __init__(self) -> None:
        super().__init__()
        named(self, "report", title="results of the experiment")
        self.table = named(QTextBrowser(), "table")
        self.plot = named(_Plot(), "plot")
        self.addTab(self.table, "Table")
        self.addTab(self.plot, "Plot")

    def show_files(self, table: Path, plot: Path) -> None:
        """Show a table in Markdown and a picture."""
        self.table.setMarkdown(table.read_text("utf-8"))
        self.plot.show_picture(QPixmap(str(plot)))


class _Plot(QLabel):
    """A picture as wide as its place."""

    def __init__(self) -> None:
        super().__init__(alignment=Qt.AlignmentFlag.AlignCenter)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Ignored)
        self._picture = QPixmap()

    def show_picture(self, picture: QPixmap) -> None:
        """Show a picture."""
        self._picture = picture
        self._fit()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Fit the picture to the new size."""
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        if not self._picture.isNull():
            ratio = self.devicePixelRatioF()
            size = (self.size() * ratio).boundedTo(self._picture.size())
            fitted = self._picture.scaled(
                size, Qt.AspectRatioMode.KeepAspectRatio, Qt.TransformationMode.SmoothTransformation
            )
            fitted.setDevicePixelRatio(ratio)
            self.setPixmap(fitted)
