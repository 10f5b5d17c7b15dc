"""The editors of the cells of the list of obstacles, and how a cell with a wrong value is painted."""

from __future__ import annotations

from PySide6.QtCore import QAbstractItemModel, QEvent, QModelIndex, QObject, QPersistentModelIndex, Qt, QTimer, Signal
from PySide6.QtGui import QBrush, QColor, QPalette
from PySide6.QtWidgets import (
    QAbstractSpinBox,
    QComboBox,
    QDoubleSpinBox,
    QHBoxLayout,
    QSpinBox,
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


class HeightCell(QSpinBox):
    """A number of levels."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setRange(2, MOST_LEVELS)

    def show_text(self, text: str) -> bool:
        """Show the text of a cell; whether it can be shown."""
        if text.isdecimal():
            self.setValue(min(int(text), MOST_LEVELS))
        return self.text() == text


class SoftnessCell(QDoubleSpinBox):
    """A percentage."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setRange(0, 100)

    def textFromValue(self, value: float) -> str:
        """The number without trailing zeros."""
        return f"{value:g}"

    def show_text(self, text: str) -> bool:
        """Show the text of a cell, none as 0; whether it can be shown."""
        try:
            self.setValue(float(text or 0))
        except ValueError:
            return False
        return self.value() == float(text or 0)


class EndCell(QWidget):
    """Two coordinates, each of which may be random; `left`: neither has the keyboard focus any more."""

    left = Signal()

    def __init__(self, parent: QWidget, grid: Grid) -> None:
        super().__init__(parent)
        self.setAutoFillBackground(True)
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(0)
        self._boxes = [named(QSpinBox(), name, tip="one below 0 is random") for name in ("x", "y")]
        for box, cells in zip(self._boxes, grid.shape, strict=True):
            box.setRange(-1, cells - 1)
            box.setSpecialValueText("random")
            box.setButtonSymbols(QAbstractSpinBox.ButtonSymbols.NoButtons)
            box.installEventFilter(self)
            row.addWidget(box)
        self.setFocusProxy(self._boxes[0])

    def show_text(self, text: str) -> bool:
        """Show the text of a cell, none as random; whether it can be shown."""
        parts = [part.strip() for part in text.split(",")] if text else ["random", "random"]
        for box, part in zip(self._boxes, parts, strict=False):
            box.setValue(int(part) if part.isdecimal() and len(part) < 10 else -1)
        return not text or [box.text() for box in self._boxes] == parts

    def text(self) -> str:
        """The text of the cell."""
        return ", ".join(box.text() for box in self._boxes)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Tell when the focus goes to another widget than the two boxes."""
        if event.type() == QEvent.Type.FocusOut:
            QTimer.singleShot(0, self, self._look)
        return super().eventFilter(watched, event)

    def _look(self) -> None:
        if not any(box.hasFocus() for box in self._boxes):
            self.left.emit()


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
        if isinstance(found, EndCell):
            found.left.connect(lambda: self._close(found))
        elif isinstance(found, KindCell):
            found.activated.connect(lambda: self._close(found))
        return found

    def setEditorData(self, editor: QWidget, index: Index) -> None:
        """Fill a text field; the other editors show their cell from the start."""
        if not isinstance(editor, KindCell | HeightCell | SoftnessCell | EndCell):
            super().setEditorData(editor, index)

    def setModelData(self, editor: QWidget, model: QAbstractItemModel, index: Index) -> None:
        """Put the text of an editor into the cell if the user has changed it."""
        if not isinstance(editor, KindCell | HeightCell | SoftnessCell | EndCell):
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

    def _editor(self, parent: QWidget, key: str) -> KindCell | HeightCell | SoftnessCell | EndCell:
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
