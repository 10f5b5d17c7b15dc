"""The table of obstacles; its cells can be edited, its rows switched off and dragged."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QItemSelectionModel, QSignalBlocker, Qt, Signal
from PySide6.QtGui import QBrush, QIcon, QKeyEvent, QMouseEvent, QPainter, QPaintEvent, QPalette, QPen
from PySide6.QtWidgets import (
    QAbstractItemView,
    QApplication,
    QHeaderView,
    QStyle,
    QTableWidget,
    QTableWidgetItem,
    QWidget,
)

from rsegen.errors import ParameterError
from rsegen.field.obstacles import Grid
from rsegen.gui.model.session import ObstacleRow
from rsegen.gui.model.typed_cells import cell_text, with_typed, wrong_cell
from rsegen.gui.widgets.cell_editors import PROBLEM, CellEditors
from rsegen.gui.widgets.message_label import ink
from rsegen.gui.widgets.named import named, tooltip

COLUMNS = ("ID", "Type", "Height", "Softness", "First", "Last")
TIP = "drag a row to move it (Alt+Up, Alt+Down); Ctrl+D duplicates, Del removes; double click to edit"
KEYS = ("", "kind", "max_height", "softness", "first", "last")
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
