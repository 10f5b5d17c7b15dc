"""The table of obstacles, its editors and buttons; cells can be edited, rows switched off and dragged."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import (
    QAbstractItemModel,
    QItemSelectionModel,
    QLineF,
    QModelIndex,
    QObject,
    QPersistentModelIndex,
    QSignalBlocker,
    QSize,
    Qt,
    Signal,
)
from PySide6.QtGui import QBrush, QColor, QIcon, QKeyEvent, QMouseEvent, QPainter, QPaintEvent, QPalette, QPen, QPixmap
from PySide6.QtWidgets import (
    QAbstractItemView,
    QAbstractSpinBox,
    QApplication,
    QComboBox,
    QHBoxLayout,
    QHeaderView,
    QPushButton,
    QStyle,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QTableWidget,
    QTableWidgetItem,
    QWidget,
)

from rsegen.errors import ParameterError
from rsegen.field.obstacles import KINDS, Grid
from rsegen.gui.model.obstacle_ends import cell_text, kind_words, with_typed, wrong_cell
from rsegen.gui.model.session import ObstacleRow
from rsegen.gui.widgets.editors import DecimalBox, IntegerBox
from rsegen.gui.widgets.layouts import ink, named, tooltip
from rsegen.params.sorts import MOST_LEVELS

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


class LevelsCell(IntegerBox):
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


CellEditor = KindCell | LevelsCell | SoftnessCell | EndCell


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
            case "levels":
                return LevelsCell(parent)
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


COLUMNS = ("ID", "Type", "Levels", "Softness", "First", "Last")
TIP = "drag a row to move it (Alt+Up, Alt+Down); Ctrl+D duplicates, Del removes; double click to edit"
KEYS = ("", "kind", "levels", "softness", "first", "last")
"""The key of an entry that each column shows."""


class ObstacleTable(QTableWidget):
    """The rows of a draft.

    chosen: a row was selected, -1 for none; switched: a row was switched on or off; edited: a row has another entry;
    shifted: a row was dragged to another.
    """

    chosen = Signal(int)
    switched = Signal(int, bool)
    edited = Signal(int, object)
    shifted = Signal(int, int)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(0, len(COLUMNS), parent)
        named(self, "rows", title="obstacles", tip=TIP)
        self.setHorizontalHeaderLabels(list(COLUMNS))
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.setWordWrap(False)
        self.verticalHeader().hide()
        self.horizontalHeader().setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        self.horizontalHeader().setHighlightSections(False)  # bold letters need more room than there is
        self.horizontalHeader().setStretchLastSection(True)
        self._rows: Sequence[ObstacleRow] = ()
        self._dragged: int | None = None
        self._pressed = 0
        self._gap: int | None = None
        self._cells = CellEditors(KEYS, self)
        self.setItemDelegate(self._cells)
        self.setTabKeyNavigation(False)
        self.itemChanged.connect(self._changed)
        self.itemSelectionChanged.connect(lambda: self.chosen.emit(self.selected))

    @property
    def selected(self) -> int:
        """The selected row, or -1."""
        found = self.selectionModel().selectedRows()
        return found[0].row() if found else -1

    def show_rows(self, rows: Sequence[ObstacleRow], selected: int, problem: ParameterError | None) -> None:
        """Show the rows of a draft without a signal; a row with a problem is red and has it as tooltip.

        A row that is being dragged is let go if the rows have changed.
        """
        if rows != self._rows:
            self._end_drag()
        self._rows = rows
        blockers = [QSignalBlocker(self), QSignalBlocker(self.selectionModel())]
        self.setRowCount(len(rows))
        wrong = wrong_cell(problem)
        for number, row in enumerate(rows):
            text = problem.problem if problem and number == wrong[0] else ""
            for column, key in enumerate(KEYS):
                item = self._show_cell(number, column, row)
                self._show_problem(item, text, marked=(number, key) == wrong)
        del blockers
        self.viewport().update()
        if selected < 0:
            self.clearSelection()
        elif selected != self.selected:
            whole_row = QItemSelectionModel.SelectionFlag.ClearAndSelect | QItemSelectionModel.SelectionFlag.Rows
            self.setCurrentCell(
                selected, max(self.currentColumn(), 0), whole_row
            )  # selectRow asks which column is at the left

    def finish_typing(self) -> None:
        """Take over a text that was typed into a cell and not yet finished with Enter."""
        if self._cells.open_editor:
            self.commitData(self._cells.open_editor)

    def show_grid(self, grid: Grid) -> None:
        """Limit the coordinates of the ends to the blocks of a map."""
        self._cells.grid = grid

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Select the row that is pressed, and start to drag it; beside the rows, select none."""
        row = self.rowAt(event.position().toPoint().y())
        super().mousePressEvent(event)
        if row < 0:
            self.chosen.emit(-1)
        elif event.button() == Qt.MouseButton.LeftButton:
            self._dragged, self._pressed = row, event.position().toPoint().y()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Show where the dragged row would be dropped."""
        if self._dragged is None:
            super().mouseMoveEvent(event)
            return
        y = event.position().toPoint().y()
        if self._gap is not None or abs(y - self._pressed) >= QApplication.startDragDistance():
            self.scrollTo(self.model().index(max(self._gap_at(y) - 1, 0), 0))
            self._show_gap(self._gap_at(y))

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """Drop the row if that changes the order."""
        held, gap = self._dragged, self._gap
        self._end_drag()
        if held is None or gap is None:
            super().mouseReleaseEvent(event)
        elif gap not in {held, held + 1}:
            self.shifted.emit(held, gap - (gap > held))

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Escape cancels a drag."""
        if event.key() == Qt.Key.Key_Escape and self._gap is not None:
            self._end_drag()
        else:
            super().keyPressEvent(event)

    def paintEvent(self, event: QPaintEvent) -> None:
        """Paint the table, and a line where the dragged row would be dropped."""
        super().paintEvent(event)
        if self._gap is not None:
            painter = QPainter(self.viewport())
            painter.setPen(QPen(self.palette().color(QPalette.ColorRole.Highlight), 3))
            y = max(self._top_of(self._gap), 1)
            painter.drawLine(0, y, self.viewport().width(), y)

    def _gap_at(self, y: int) -> int:
        """The row before which a drop at y would be; the number of rows means after the last."""
        middles = [self.rowViewportPosition(row) + self.rowHeight(row) / 2 for row in range(self.rowCount())]
        return sum(middle < y for middle in middles)

    def _top_of(self, gap: int) -> int:
        last = self.rowCount() - 1
        return self.rowViewportPosition(gap) if gap <= last else self.rowViewportPosition(last) + self.rowHeight(last)

    def _show_gap(self, gap: int | None) -> None:
        self._gap = gap
        self.viewport().setCursor(Qt.CursorShape.ArrowCursor if gap is None else Qt.CursorShape.ClosedHandCursor)
        self.viewport().update()

    def _end_drag(self) -> None:
        self._dragged = None
        self._show_gap(None)

    def _changed(self, item: QTableWidgetItem) -> None:
        number, key = item.row(), KEYS[item.column()]
        if key:
            self.edited.emit(number, with_typed(self._rows[number].entry, key, item.text()))
            blocker = QSignalBlocker(self)
            self._show_cell(number, item.column(), self._rows[number])  # also a text that changed nothing, such as " 5"
            del blocker
        else:
            self.switched.emit(number, item.checkState() == Qt.CheckState.Checked)

    def _show_cell(self, number: int, column: int, row: ObstacleRow) -> QTableWidgetItem:
        """The item of one cell, which shows the value of a row."""
        item, key = self.item(number, column), KEYS[column]
        if item is None:
            item = QTableWidgetItem()
            self.setItem(number, column, item)
        item.setText(cell_text(row.entry, key) if key else str(number + 1))
        if not key:
            item.setFlags(item.flags() & ~Qt.ItemFlag.ItemIsEditable | Qt.ItemFlag.ItemIsUserCheckable)
            item.setCheckState(Qt.CheckState.Checked if row.enabled else Qt.CheckState.Unchecked)
        return item

    def _show_problem(self, item: QTableWidgetItem, text: str, *, marked: bool) -> None:
        """Show a problem of a row as the tooltip of a cell; the one that is wrong is marked."""
        item.setForeground(ink("error", self.palette()) if text else QBrush())
        item.setToolTip(tooltip(text))
        item.setData(PROBLEM, text if marked else None)
        item.setIcon(self.style().standardIcon(QStyle.StandardPixmap.SP_MessageBoxWarning) if marked else QIcon())


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
