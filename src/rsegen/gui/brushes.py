"""What to paint cells with, above the plan."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QHBoxLayout, QLabel, QPushButton, QSpinBox, QWidget

from rsegen.gui.editors import named

_HIGHEST = 32766
_TIP = (
    "paint single cells (P): the mouse paints, its right button takes paint off; on the keyboard arrows move, a digit "
    "sets the cell to that level and goes on to the next, Space paints, Backspace takes off"
)


class Brushes(QWidget):
    """A button that takes the brush or lays it down, and the level that it paints; `chosen` tells it, or None."""

    chosen = Signal(object)

    def __init__(self) -> None:
        super().__init__()
        self.taken = named(QPushButton("Paint cells"), "paint", tip=_TIP)
        self.taken.setCheckable(True)
        self.level = named(QSpinBox(prefix="level ", maximum=_HIGHEST, value=1), "paint_level", title="level to paint")
        self._height = named(QLabel(), "paint_height")
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        for widget in (self.taken, self.level, self._height):
            row.addWidget(widget)
        row.addStretch(1)
        self._unit = 10.0
        self.taken.toggled.connect(self._tell)
        self.level.valueChanged.connect(self._tell)
        self.show_unit(self._unit)

    def show_unit(self, unit_cm: float) -> None:
        """Say how high the level is in units of so many centimetres."""
        self._unit = unit_cm
        self.level.setEnabled(self.taken.isChecked())
        self._height.setText(f"{self.level.value() * unit_cm:g} cm" if self.taken.isChecked() else "")

    def _tell(self) -> None:
        self.show_unit(self._unit)
        self.chosen.emit(self.level.value() if self.taken.isChecked() else None)
