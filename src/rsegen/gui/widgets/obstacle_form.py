"""The form of one obstacle: kind, parameters, and four sliders for its ends, as in the paper's window."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import QCheckBox, QComboBox, QFormLayout, QGridLayout, QLabel, QSlider, QVBoxLayout, QWidget

from rsegen.field.obstacles import KINDS, Grid
from rsegen.gui.model.session import Entry
from rsegen.gui.widgets.editors import Editor, editor
from rsegen.gui.widgets.named import named
from rsegen.params.registry import summary
from rsegen.params.sorts import Json, parameters
from rsegen.recipe.recipe import Placement

DEFAULT = {"kind": "horizontal_barrier", "max_height": 5, "softness": 0}


class Coordinate(QWidget):
    """A slider for one coordinate, with its number below and a box that makes it random."""

    edited = Signal()

    def __init__(self, title: str) -> None:
        super().__init__()
        self.slider = named(QSlider(Qt.Orientation.Horizontal), title.lower().replace(" ", "_"), title=title)
        self._number = QLabel("0", alignment=Qt.AlignmentFlag.AlignCenter)
        self.random = named(QCheckBox("random"), f"{self.slider.objectName()}_random", tip="drawn anew for every map")
        grid = QGridLayout(self)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setVerticalSpacing(0)
        grid.addWidget(QLabel(title), 0, 0)
        grid.addWidget(self.random, 0, 1, alignment=Qt.AlignmentFlag.AlignRight)
        grid.addWidget(self.slider, 1, 0, 1, 2)
        grid.addWidget(self._number, 2, 0, 1, 2)
        self.slider.valueChanged.connect(self._moved)
        self.random.toggled.connect(self._moved)

    def value(self) -> Json:
        """The coordinate, or `random`."""
        return "random" if self.random.isChecked() else self.slider.value()

    def show_value(self, value: Json, cells: int) -> None:
        """Show a value without a signal; the slider covers the map's cells."""
        blockers = [QSignalBlocker(self.slider), QSignalBlocker(self.random)]
        self.slider.setRange(0, cells - 1)
        self.random.setChecked(value == "random")
        if value != "random":
            self.slider.setValue(value)
        del blockers
        self._label()

    def _moved(self) -> None:
        self._label()
        self.edited.emit()

    def _label(self) -> None:
        self.slider.setEnabled(not self.random.isChecked())
        self._number.setText(str(self.value()))


class ObstacleForm(QWidget):
    """Edits one obstacle as an entry of a recipe file; `edited` is emitted when the user changes it."""

    edited = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.kind = named(QComboBox(), "kind", title="obstacle type")
        self.kind.addItems(list(KINDS))
        self.kind.currentTextChanged.connect(self._change_kind)
        self.default_ends = named(QCheckBox(), "default_ends")
        self.default_ends.toggled.connect(self._emit)
        self.coordinates = [Coordinate(title) for title in ("X first", "Y first", "X last", "Y last")]
        self._heights = named(QLabel(wordWrap=True), "heights")
        self._editors: dict[str, Editor] = {}
        self._fields = QFormLayout()
        for coordinate in self.coordinates:
            coordinate.edited.connect(self._emit)
        self._lay_out()
        self._grid, self._unit = Grid(10, 10, 10), 10.0
        self.show_entry(DEFAULT, self._grid, self._unit)

    def entry(self) -> dict[str, Json]:
        """The obstacle in the form, as a recipe file has it."""
        values = {name: each.value() for name, each in self._editors.items()}
        found = {"kind": self.kind.currentText()} | {name: value for name, value in values.items() if value is not None}
        if not self.default_ends.isChecked():
            x1, y1, x2, y2 = (coordinate.value() for coordinate in self.coordinates)
            found |= {"first": [x1, y1], "last": [x2, y2]}
        return found

    def show_entry(self, entry: Entry, grid: Grid, unit_cm: float) -> None:
        """Show an obstacle without a signal; an unknown kind, typed into the table, leaves the form as it is."""
        self._grid, self._unit = grid, unit_cm
        if entry["kind"] not in KINDS:
            return
        blocker = QSignalBlocker(self.kind)
        self.kind.setCurrentText(entry["kind"])
        del blocker
        self._make_fields()
        for name, each in self._editors.items():
            each.show_value(entry.get(name, _default(entry["kind"], name)))
        self._show_ends(entry)
        self._describe()

    def _lay_out(self) -> None:
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        top = QFormLayout()
        top.addRow("Obstacle type", self.kind)
        column.addLayout(top)
        column.addLayout(self._fields)
        column.addWidget(self._heights)
        column.addWidget(self.default_ends)
        ends = QGridLayout()
        column.addLayout(ends)
        for number, coordinate in enumerate(self.coordinates):
            ends.addWidget(coordinate, number % 2, number // 2)

    def _show_ends(self, entry: Entry) -> None:
        blocker = QSignalBlocker(self.default_ends)
        self.default_ends.setChecked("first" not in entry and "last" not in entry)
        del blocker
        ends = [*_pair(entry.get("first"), (0, 0)), *_pair(entry.get("last"), self._grid.shape, back=1)]
        for coordinate, value, cells in zip(self.coordinates, ends, self._grid.shape * 2, strict=True):
            coordinate.show_value(value, cells)

    def _make_fields(self) -> None:
        """Replace the fields if another kind is chosen."""
        names = list(_names(self.kind.currentText()))
        if names == list(self._editors):
            return
        while self._fields.rowCount():
            self._fields.removeRow(0)
        self._editors = {}
        kind = KINDS[self.kind.currentText()]
        for name in names:
            self._editors[name] = each = editor(kind if name in parameters(kind) else Placement, name)
            each.edited.connect(self._emit)
            self._fields.addRow(name.replace("_", " ").capitalize(), each)
        _tab_through(self.kind, *(field for each in self._editors.values() for field in each.fields), self.default_ends)

    def _change_kind(self) -> None:
        self.show_entry(self.entry(), self._grid, self._unit)
        self.edited.emit()

    def _emit(self) -> None:
        self._describe()
        self.edited.emit()

    def _describe(self) -> None:
        for coordinate in self.coordinates:
            coordinate.setVisible(not self.default_ends.isChecked())
        cls = KINDS[self.kind.currentText()]
        self.kind.setToolTip(summary(cls))
        self.default_ends.setText(cls.default_place)
        top = self._editors["max_height"].value()
        shown = [f"{level * self._unit:g}" for level in range(min(top, 12))] + ["..."] * (top > 12)
        self._heights.setText(f"Heights: {', '.join(shown)} cm")


def _tab_through(*widgets: QWidget) -> None:
    for one, next_ in pairwise(widgets):
        QWidget.setTabOrder(one, next_)


def _names(kind: str) -> Iterator[str]:
    yield from parameters(KINDS[kind])
    yield "blend"


def _default(kind: str, name: str) -> Json:
    fields = {**KINDS[kind].__dataclass_fields__, **Placement.__dataclass_fields__}
    return fields[name].default


def _pair(place: Json, default: tuple[int, int], back: int = 0) -> list[Json]:
    if place == "random":
        return ["random", "random"]
    return list(place) if place else [cells - back for cells in default]
