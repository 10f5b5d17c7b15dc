"""The buttons above the list of obstacles that change it: +, - and C, as in the paper's window."""

from __future__ import annotations

from PySide6.QtCore import QLineF, QSize, Qt
from PySide6.QtGui import QColor, QIcon, QPainter, QPalette, QPen, QPixmap
from PySide6.QtWidgets import QHBoxLayout, QPushButton, QWidget

from rsegen.gui.widgets.named import named

_SIDE = 16
_LINES = {
    "add": (QLineF(2, 8, 14, 8), QLineF(8, 2, 8, 14)),
    "remove": (QLineF(2, 8, 14, 8),),
    "clear": (QLineF(3, 3, 13, 13), QLineF(13, 3, 3, 13)),
}
"""The strokes of the icons, in pixels."""


class ListBar(QWidget):
    """Add, remove and clear: the owner connects the buttons."""

    def __init__(self) -> None:
        super().__init__()
        self.add = self._button("add", "Add", "add obstacle", "add the obstacle of the form to the list (Ctrl+Return)")
        tip = "remove the selected obstacle (Del); if none is selected, the last one"
        self.remove = self._button("remove", "Remove", "remove obstacle", tip)
        self.clear = self._button("clear", "Clear", "clear all obstacles", "remove all obstacles")
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        for button in (self.add, self.remove, self.clear):
            row.addWidget(button)
        row.addStretch(1)

    def show_rows(self, rows: int, *, is_selected: bool) -> None:
        """Enable what can be done with a list of this many rows; with a selected one, Add adds a copy of it."""
        self.add.setText("Add copy" if is_selected else "Add")
        for button in (self.remove, self.clear):
            button.setEnabled(rows > 0)

    def _button(self, name: str, text: str, title: str, tip: str) -> QPushButton:
        button = named(QPushButton(text), name, title=title, tip=tip)
        button.setIcon(_icon(name, self.palette().color(QPalette.ColorRole.ButtonText)))
        button.setIconSize(QSize(_SIDE, _SIDE))
        return button


def _icon(name: str, ink: QColor) -> QIcon:
    """The icon of a button, sharp at twice the size too."""
    picture = QPixmap(2 * _SIDE, 2 * _SIDE)
    picture.setDevicePixelRatio(2)
    picture.fill(Qt.GlobalColor.transparent)
    painter = QPainter(picture)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.setPen(QPen(ink, 2.4, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap))
    painter.drawLines(list(_LINES[name]))
    painter.end()
    return QIcon(picture)
