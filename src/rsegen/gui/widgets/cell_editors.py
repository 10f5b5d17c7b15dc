"""The editors of the cells of the list of obstacles, and how a cell with a wrong value is painted."""

from __future__ import annotations

from PySide6.QtCore import QAbstractItemModel, QModelIndex, QObject, QPersistentModelIndex, Qt
from PySide6.QtGui import QBrush, QColor, QPalette
from PySide6.QtWidgets import (
    QAbstractSpinBox,
    QComboBox,
    QStyle,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QWidget,
)

from rsegen.field.obstacles import KINDS, Grid
from rsegen.field.obstacles.base import MOST_LEVELS
from rsegen.gui.model.typed_cells import kind_words
from rsegen.gui.widgets.message_label import ink
from rsegen.gui.widgets.named import named
from rsegen.gui.widgets.number_boxes import DecimalBox, IntegerBox

PROBLEM = Qt.ItemDataRole.UserRole
"""The role of a cell's data that says what is wrong with it."""

Index = QModelIndex | QPersistentModelIndex


class KindCell(QComboBox):
    """A list of the obstacle kinds."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.addItems([kind_words(kind) for kind in KINDS])

    def show_text(self, text: str) -> bool:
        """Show the text of a cell; whether it can be shown."""
        self.setCurrentText(text)
        return self.currentText() == text

    def text(self) -> str:
        """The text of the cell."""
        return self.currentText()


class HeightCell(IntegerBox):
    """A number of levels."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setRange(2, MOST_LEVELS)

    def show_text(self, text: str) -> bool:
        """Show the text of a cell; whether it can be shown."""
        if text.isdecimal():
            self.setValue(min(int(text), MOST_LEVELS))
        return self.text() == text


class SoftnessCell(DecimalBox):
    """A percentage."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setRange(0, 100)

    def show_text(self, text: str) -> bool:
        """Show the text of a cell, none as 0; whether it can be shown."""
        try:
            self.setValue(float(text or 0))
        except ValueError:
            return False
        return self.value() == float(text or 0)


class EndCell(QAbstractSpinBox):
    """Two coordinates, each of which may be random; arrow keys count the one that has the cursor."""

    def __init__(self, parent: QWidget, grid: Grid) -> None:
        super().__init__(parent)
        self._highest = [cells - 1 for cells in grid.shape]
        self.setToolTip("x, y; the arrow keys count up and down, one below 0 is random")

    def show_text(self, text: str) -> bool:
        """Show the text of a cell, none as random; whether it can be shown."""
        self.lineEdit().setText(text or "random, random")
        return self._numbers() is not None

    def stepBy(self, steps: int) -> None:
        """Count the coordinate that has the cursor."""
        if numbers := self._numbers():
            axis = self._axis()
            numbers[axis] = min(max(numbers[axis] + steps, -1), self._highest[axis])
            parts = ["random" if number < 0 else str(number) for number in numbers]
            self.lineEdit().setText(", ".join(parts))
            self.lineEdit().setSelection(0 if axis == 0 else len(parts[0]) + 2, len(parts[axis]))

    def stepEnabled(self) -> QAbstractSpinBox.StepEnabledFlag:
        """Both ways, if there are two coordinates."""
        up, down = QAbstractSpinBox.StepEnabledFlag.StepUpEnabled, QAbstractSpinBox.StepEnabledFlag.StepDownEnabled
        return up | down if self._numbers() else QAbstractSpinBox.StepEnabledFlag.StepNone

    def _axis(self) -> int:
        """The coordinate that has the cursor, or that is selected."""
        line = self.lineEdit()
        start = line.selectionStart() if line.hasSelectedText() else line.cursorPosition()
        return int(start > line.text().find(","))

    def _numbers(self) -> list[int] | None:
        """Both coordinates, -1 for random; None if the text is no two of them."""
        parts = [part.strip() for part in self.text().split(",")]
        known = all(part == "random" or (part.isdecimal() and len(part) < 10) for part in parts)
        return [-1 if part == "random" else int(part) for part in parts] if known and len(parts) == 2 else None


CellEditor = KindCell | HeightCell | SoftnessCell | EndCell


class CellEditors(QStyledItemDelegate):
    """Gives each column its editor; a text that it cannot show is edited as text."""

    def __init__(self, keys: tuple[str, ...], parent: QObject) -> None:
        super().__init__(parent)
        self.grid = Grid(10, 10, 10)
        self.open_editor: QWidget | None = None
        self._keys, self._given = keys, ""

    def createEditor(self, parent: QWidget, option: QStyleOptionViewItem, index: Index) -> QWidget:
        """The editor of a column, or a text field if it cannot show what is in the cell."""
        text = index.data() or ""
        found = self._editor(parent, self._keys[index.column()])
        if not found.show_text(text):
            found.deleteLater()
            self.open_editor = super().createEditor(parent, option, index)
            return self.open_editor
        self.open_editor = named(found, "cell_editor", title=self._keys[index.column()].replace("_", " "))
        self._given = found.text()
        if isinstance(found, KindCell):
            found.activated.connect(lambda: self._close(found))
        return found

    def setEditorData(self, editor: QWidget, index: Index) -> None:
        """Fill a text field; the other editors show their cell from the start."""
        if not isinstance(editor, CellEditor):
            super().setEditorData(editor, index)

    def setModelData(self, editor: QWidget, model: QAbstractItemModel, index: Index) -> None:
        """Put the text of an editor into the cell if the user has changed it."""
        if not isinstance(editor, CellEditor):
            super().setModelData(editor, model, index)
        elif editor.text() != self._given:
            model.setData(index, editor.text())

    def initStyleOption(self, option: QStyleOptionViewItem, index: Index) -> None:
        """A wrong cell is red with its reason, also in the selected row."""
        super().initStyleOption(option, index)
        problem = index.data(PROBLEM)
        if problem:
            option.text = f"{option.text}  ({problem})"
            option.state &= ~QStyle.StateFlag.State_Selected
            colour = ink("error", option.palette)
            option.palette.setColor(QPalette.ColorRole.Text, colour)
            option.backgroundBrush = QBrush(_tint(option.palette.color(QPalette.ColorRole.Base), colour))

    def _editor(self, parent: QWidget, key: str) -> CellEditor:
        match key:
            case "kind":
                return KindCell(parent)
            case "max_height":
                return HeightCell(parent)
            case "softness":
                return SoftnessCell(parent)
        return EndCell(parent, self.grid)

    def _close(self, editor: QWidget) -> None:
        """Take over an editor and close it, unless the list has let it go already."""
        if editor is self.open_editor:
            self.commitData.emit(editor)
            self.closeEditor.emit(editor)

    def destroyEditor(self, editor: QWidget, index: Index) -> None:
        """Forget an editor that the list lets go."""
        self.open_editor = None
        super().destroyEditor(editor, index)


def _tint(base: QColor, colour: QColor) -> QColor:
    """A sixth of a colour on a base; opaque, so that no selection shows through."""
    mixed = [round((5 * own + other) / 6) for own, other in zip(base.getRgb()[:3], colour.getRgb()[:3], strict=True)]  # type: ignore[index]
    return QColor(*mixed)
