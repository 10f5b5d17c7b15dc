"""The legend of the 3D view: the colour and height of each level."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QRect, QSize, Qt
from PySide6.QtGui import QColor, QPainter, QPaintEvent
from PySide6.QtWidgets import QSizePolicy, QWidget

from rsegen.gui.model.colours import Rgb

_PAD = 8


class Legend(QWidget):
    """A column of colours with their names."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._rows: Sequence[tuple[Rgb, str]] = ()
        self.setAccessibleName("Legend")
        self.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Preferred)

    def show_rows(self, rows: Sequence[tuple[Rgb, str]]) -> None:
        """Show these colours and names, from top to bottom."""
        if rows == self._rows:
            return
        self._rows = rows
        self.setAccessibleDescription(", ".join(name for _, name in rows))
        self.updateGeometry()
        self.update()

    def sizeHint(self) -> QSize:
        """Wide enough for the longest name."""
        metrics = self.fontMetrics()
        longest = max((metrics.horizontalAdvance(name) for _, name in self._rows), default=0)
        return QSize(longest + metrics.height() + 3 * _PAD, len(self._rows) * self._row + 2 * _PAD)

    def paintEvent(self, event: QPaintEvent) -> None:
        """Paint the rows, vertically centred."""
        painter = QPainter(self)
        side = self.fontMetrics().ascent()
        top = max((self.height() - len(self._rows) * self._row) // 2, 0)
        for number, (colour, name) in enumerate(self._rows):
            y = top + number * self._row
            painter.fillRect(_PAD, y + (self._row - side) // 2, side, side, QColor(*colour))
            painter.setPen(self.palette().text().color())
            left = 2 * _PAD + side
            painter.drawText(QRect(left, y, self.width() - left, self._row), Qt.AlignmentFlag.AlignVCenter, name)

    @property
    def _row(self) -> int:
        return self.fontMetrics().height() + 4
