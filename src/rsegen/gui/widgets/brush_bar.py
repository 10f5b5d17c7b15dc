"""The tools above the plan to paint cells."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QHBoxLayout, QLabel, QPushButton, QSpinBox, QWidget

from rsegen.gui.widgets.named import named

_HIGHEST = 32766
_TIP = (
    "paint single cells (P): the left mouse button paints, the right one erases; on the keyboard arrows move, a digit "
    "sets the cell to that level and moves to the next, Space paints, Backspace erases"
)


class BrushBar(QWidget):
    """A button that switches painting on and off, and the level to paint; `chosen` gives that level, None if off."""

    chosen = Signal(object)

    def __init__(self) -> None:
        super().__init__()
        self.paint = named(QPushButton("Paint cells"), "paint", tip=_TIP)
        self.paint.setCheckable(True)
        self.level = named(QSpinBox(prefix="level ", maximum=_HIGHEST, value=1), "paint_level", title="level to paint")
        self._height = named(QLabel(), "paint_height")
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        for widget in (self.paint, self.level, self._height):
            row.addWidget(widget)
        row.addStretch(1)
        self._unit = 10.0
        self.paint.toggled.connect(self._emit)
        self.level.valueChanged.connect(self._emit)
        self.show_unit(self._unit)

    def show_unit(self, unit_cm: float) -> None:
        """Show the height of the level for a unit of some centimetres."""
        self._unit = unit_cm
        self.level.setEnabled(self.paint.isChecked())
        self._height.setText(f"{self.level.value() * unit_cm:g} cm" if self.paint.isChecked() else "")

    def _emit(self) -> None:
        self.show_unit(self._unit)
        self.chosen.emit(self.level.value() if self.paint.isChecked() else None)
