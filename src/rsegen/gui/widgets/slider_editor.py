"""An editor with a slider and a number for a parameter of few usual values."""

from __future__ import annotations

from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtWidgets import QSlider, QWidget

from rsegen.gui.widgets.editors import NumberEditor
from rsegen.params.sorts import Json, Parameter


class SliderEditor(NumberEditor):
    """A slider and a spin box for a number; the slider ends at `most`, the box may go beyond."""

    _parts = (" slider", "")

    def __init__(self, name: str, parameter: Parameter, most: int) -> None:
        self._most = most
        super().__init__(name, parameter)

    def _widgets(self) -> tuple[QWidget, ...]:
        (box,) = super()._widgets()
        self._slider = QSlider(Qt.Orientation.Horizontal)
        self._slider.setRange(int(self._low), self._most)
        self._slider.valueChanged.connect(self._box.setValue)
        self._box.valueChanged.connect(self._follow)
        self._row.setStretch(0, 1)
        return self._slider, box

    def _put(self, value: Json) -> None:
        super()._put(value)
        self._follow()

    def _put_invalid(self, value: Json) -> None:
        super()._put_invalid(value)
        self._follow()

    def _follow(self) -> None:
        """Move the slider to the number in the box, as near as it can."""
        blocker = QSignalBlocker(self._slider)
        self._slider.setValue(min(int(self._box.value()), self._most))
        del blocker
