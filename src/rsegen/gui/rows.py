"""The list of obstacles: ID, on or off, type, height, softness, (X, Y) first and last; cells can be edited in place."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import QAbstractItemView, QHeaderView, QTableWidget, QTableWidgetItem, QWidget

from rsegen.errors import ParameterError
from rsegen.gui.editors import named
from rsegen.gui.session import Row
from rsegen.obstacles import KINDS
from rsegen.params import Json, parameters
from rsegen.recipe import Placement

COLUMNS = ("ID", "Type", "Height", "Softness", "First", "Last")
KEYS = ("", "kind", "max_height", "softness", "first", "last")
"""What of an entry each column shows."""


class Rows(QTableWidget):
    """The rows of a draft; it tells which was chosen, switched on or off, or edited in place."""

    chosen = Signal(int)
    switched = Signal(int, bool)
    edited = Signal(int, object)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(0, len(COLUMNS), parent)
        named(self, "rows", title="obstacles")
        self.setHorizontalHeaderLabels(list(COLUMNS))
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.verticalHeader().hide()
        self.horizontalHeader().setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        self.horizontalHeader().setStretchLastSection(True)
        self._rows: Sequence[Row] = ()
        self.itemChanged.connect(self._changed)
        self.itemSelectionChanged.connect(lambda: self.chosen.emit(self.selected))

    @property
    def selected(self) -> int:
        """The row that is chosen, or -1."""
        found = self.selectionModel().selectedRows()
        return found[0].row() if found else -1

    def show_rows(self, rows: Sequence[Row], selected: int, problem: ParameterError | None) -> None:
        """Put the rows of a draft into the table, silently; the one with a problem is red and says it in its tip."""
        self._rows = rows
        blockers = [QSignalBlocker(self), QSignalBlocker(self.selectionModel())]
        self.setRowCount(len(rows))
        for number, row in enumerate(rows):
            wrong = problem.problem if problem and problem.where.startswith(f"obstacles[{number}]") else ""
            for column, key in enumerate(KEYS):
                self.setItem(number, column, _item(number, row, key, wrong))
        del blockers
        if selected < 0:
            self.clearSelection()
        elif selected != self.selected:
            self.selectRow(selected)

    def _changed(self, item: QTableWidgetItem) -> None:
        row, key = self._rows[item.row()], KEYS[item.column()]
        if not key:
            self.switched.emit(item.row(), item.checkState() == Qt.CheckState.Checked)
            return
        entry = {name: value for name, value in row.entry.items() if name != key}
        if item.text().strip():
            entry[key] = _parsed(row.entry["kind"], key, item.text().strip())
        self.edited.emit(item.row(), entry)


def _item(number: int, row: Row, key: str, wrong: str) -> QTableWidgetItem:
    item = QTableWidgetItem(_text(row.entry.get(key)) if key else str(number + 1))
    if not key:
        item.setFlags(item.flags() & ~Qt.ItemFlag.ItemIsEditable | Qt.ItemFlag.ItemIsUserCheckable)
        item.setCheckState(Qt.CheckState.Checked if row.enabled else Qt.CheckState.Unchecked)
    if wrong:
        item.setForeground(Qt.GlobalColor.red)
        item.setToolTip(wrong)
    return item


def _text(value: Json) -> str:
    if value is None:
        return ""
    return ", ".join(map(str, value)) if isinstance(value, (list, tuple)) else str(value)


def _parsed(kind: str, key: str, text: str) -> Json:
    if key == "kind":
        return text
    sort = {**parameters(KINDS[kind]), **parameters(Placement)}[key]
    found = sort.parse(text.replace(" ", ""))
    return list(found) if isinstance(found, tuple) else found
