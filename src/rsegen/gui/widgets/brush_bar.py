"""The tools above the plan to paint cells."""

from __future__ import annotations

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QColor, QIcon, QPixmap, QShortcut
from PySide6.QtWidgets import (
    QButtonGroup,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from rsegen.exporters.scene import Scene
from rsegen.gui.model.colours import GROUND, centimetres, rgb
from rsegen.gui.model.painting import Brush, Tool
from rsegen.gui.widgets.editors import IntegerBox
from rsegen.gui.widgets.layouts import named, row_of

_HIGHEST = 32766
_SWATCHES = 8
_CHECKED = "QToolButton:checked { border: 2px solid palette(highlight); border-radius: 3px; padding: 1px; }"
"""In dark palettes some styles hardly show which button is checked."""

_TIP = (
    "paint single cells (P): the left mouse button paints, the right one erases; on the keyboard arrows move, a digit "
    "sets the cell to that level and moves to the next, Space paints, Backspace erases"
)
_TOOLS = {
    Tool.CELLS: ("Cells", "B", "paint every cell that the mouse comes over"),
    Tool.RECTANGLE: ("Box", "R", "paint all cells between the corners of a drag"),
    Tool.FILL: ("Fill", "F", "paint all cells of the same level that are connected with the one that is clicked"),
    Tool.PICK: ("Pick", "I", "take over the level of the cell that is clicked"),
}


class BrushBar(QWidget):
    """A button that switches painting on and off, tools, and the level to paint.

    chosen: gives the Brush, None while painting is off.
    """

    chosen = Signal(object)

    def __init__(self) -> None:
        super().__init__()
        self.paint = named(QPushButton("Paint cells"), "paint", tip=_TIP)
        self.paint.setCheckable(True)
        self.level = named(IntegerBox(prefix="level "), "paint_level", title="level to paint")
        self.level.setMaximum(_HIGHEST)
        self.level.setValue(1)
        self.level.setToolTip("the level to paint; its height stands on the right")
        self._height = named(QLabel(), "paint_height")
        self._tools, self._swatches = QButtonGroup(self), QButtonGroup(self)
        self._shortcuts: list[QShortcut] = []
        self._unit = 10.0
        self._lay_out()
        self.paint.toggled.connect(self._emit)
        self.level.valueChanged.connect(self._emit)
        self._tools.buttonClicked.connect(self._emit)
        self._swatches.idClicked.connect(self.level.setValue)
        self._emit()

    @property
    def brush(self) -> Brush:
        """The tool and the level that are chosen."""
        return Brush(list(_TOOLS)[self._tools.checkedId()], self.level.value())

    def show_unit(self, unit_cm: float) -> None:
        """Show the height of the level for a unit of some centimetres."""
        self._unit = unit_cm
        self._height.setText(f"{self.level.value() * unit_cm:g} cm" if self.paint.isChecked() else "")

    def show_scene(self, scene: Scene) -> None:
        """Show the colours and heights of the levels that a map can have."""
        levels = max(min(scene.recipe.highest_level + 1, _SWATCHES), 2)
        for level, button in enumerate(self._swatches.buttons()):
            colour = QPixmap(12, 12)
            colour.fill(QColor(*(rgb(scene, level) if level else GROUND)))
            height = centimetres(level * scene.field.unit)
            button.setIcon(QIcon(colour))
            button.setText(height.removesuffix(" cm"))
            button.setToolTip(f"paint level {level}: {height}")
            button.setAccessibleName(f"level {level}: {height}")
            button.setVisible(level < levels)

    def pick(self, level: int) -> None:
        """Take over a level, and paint cells with it."""
        self._tools.button(0).setChecked(True)
        self.level.setValue(level)
        self._emit()

    def _lay_out(self) -> None:
        tools, swatches = QHBoxLayout(), QHBoxLayout()
        for number, (text, key, tip) in enumerate(_TOOLS.values()):
            tools.addWidget(self._button(self._tools, number, f"paint_{text.lower()}", f"{tip} ({key})"))
            self._tools.button(number).setText(text)
            shortcut = QShortcut(key, self)
            shortcut.activated.connect(self._tools.button(number).click)
            self._shortcuts.append(shortcut)
        for level in range(_SWATCHES):
            swatches.addWidget(self._button(self._swatches, level, f"paint_level_{level}", f"paint level {level}"))
        self._tools.button(0).setChecked(True)
        self._more = QWidget()
        self._more.setStyleSheet(_CHECKED)
        column = QVBoxLayout(self._more)
        for row in (tools, swatches):
            row.addStretch(1)
            row.setSpacing(2)
            column.addLayout(row)
        whole = QVBoxLayout(self)
        first = row_of(self.paint, self.level, self._height)
        first.addStretch(1)
        whole.addLayout(first)
        whole.addWidget(self._more)
        for box in (column, whole):
            box.setContentsMargins(0, 0, 0, 0)
            box.setSpacing(3)

    def _button(self, group: QButtonGroup, number: int, name: str, tip: str) -> QToolButton:
        button = named(QToolButton(), name, tip=tip)
        button.setCheckable(True)
        button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        button.setIconSize(QSize(12, 12))
        button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        group.addButton(button, number)
        return button

    def _emit(self) -> None:
        is_on = self.paint.isChecked()
        self.show_unit(self._unit)
        self.level.setVisible(is_on)
        self._more.setVisible(is_on)
        for group in (self._tools, self._swatches):
            for button in group.buttons():
                button.setEnabled(is_on)
        for shortcut in self._shortcuts:
            shortcut.setEnabled(is_on)
        self._swatches.setExclusive(False)
        for level, button in enumerate(self._swatches.buttons()):
            button.setChecked(level == self.level.value())
        self._swatches.setExclusive(self.level.value() < _SWATCHES)
        self.chosen.emit(self.brush if is_on else None)
