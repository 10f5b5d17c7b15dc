"""The ends of an obstacle: a slider, a number and a box for random per coordinate, and one box for the default ends."""

from __future__ import annotations

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import QAbstractSpinBox, QCheckBox, QGridLayout, QLabel, QSlider, QVBoxLayout, QWidget

from rsegen.field.obstacles import Grid
from rsegen.gui.model.session import Entry
from rsegen.gui.widgets.editors import shortened
from rsegen.gui.widgets.layouts import scroll_past
from rsegen.gui.widgets.named import named
from rsegen.gui.widgets.number_boxes import IntegerBox
from rsegen.params.sorts import Json

_MOST = 2**31 - 1


class Coordinate(QWidget):
    """A slider for one coordinate, a field with its number below, and a box that makes it random.

    A value that the slider cannot show stands in the field as text, and is kept until the user changes it.
    """

    edited = Signal()

    def __init__(self, title: str) -> None:
        super().__init__()
        name, tip = title.lower().replace(" ", "_"), f"{title}, in blocks of the map, counted from 0"
        self.slider = named(QSlider(Qt.Orientation.Horizontal), name, title=f"{title} slider", tip=tip)
        self.number = named(IntegerBox(), f"{name}_number", title=title, tip=tip)
        self.number.setButtonSymbols(QAbstractSpinBox.ButtonSymbols.NoButtons)
        self.number.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.random = named(QCheckBox("random"), f"{name}_random", tip="drawn anew for every map")
        self._given = self._read()
        self._shown: Json = self._given
        self._lay_out(title)
        for field in (self.slider, self.number):
            scroll_past(field)
        self.slider.valueChanged.connect(self._slide)
        self.number.valueChanged.connect(self._type)
        self.random.toggled.connect(self._change)

    def value(self) -> Json:
        """The coordinate, or `random`."""
        read = self._read()
        return self._given if read == self._shown else read

    def show_value(self, value: Json, cells: int) -> None:
        """Show a value without a signal; the slider covers the map's cells."""
        blockers = [QSignalBlocker(each) for each in (self.slider, self.number, self.random)]
        self.slider.setRange(0, min(cells - 1, _MOST))
        self.random.setChecked(value == "random")
        if isinstance(value, int):
            self.slider.setValue(min(max(value, 0), self.slider.maximum()))
        self._show_number(value)
        del blockers
        self._given, self._shown = value, self._read()

    def _lay_out(self, title: str) -> None:
        grid = QGridLayout(self)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setVerticalSpacing(0)
        grid.addWidget(QLabel(title), 0, 0)
        grid.addWidget(self.random, 0, 1, alignment=Qt.AlignmentFlag.AlignRight)
        grid.addWidget(self.slider, 1, 0, 1, 2)
        grid.addWidget(self.number, 2, 0, 1, 2, alignment=Qt.AlignmentFlag.AlignHCenter)

    def _read(self) -> Json:
        if self.random.isChecked():
            return "random"
        return self.slider.value() if self.number.value() < 0 else self.number.value()

    def _slide(self, value: int) -> None:
        self._show_number(value)
        self._change()

    def _type(self, number: int) -> None:
        """Take over a number that was typed, also one beyond the map, whose error says so."""
        blocker = QSignalBlocker(self.slider)
        self.slider.setValue(number)
        del blocker
        self._change()

    def _change(self) -> None:
        """Take over what the user has set, also where it is what the slider showed for another value."""
        self._shown = None
        self._show_number(self._read())
        self.edited.emit()

    def _show_number(self, value: Json) -> None:
        """Show a value in the field; Qt has a text for its minimum, which is one below the range for as long."""
        blocker = QSignalBlocker(self.number)
        is_shown = isinstance(value, int) and 0 <= value <= _MOST
        self.number.setSpecialValueText("" if is_shown else shortened(value))
        self.number.setRange(0 if is_shown else -1, _MOST)
        self.number.setValue(value if is_shown else -1)
        del blocker
        for each in (self.slider, self.number):
            each.setEnabled(not self.random.isChecked())


class EndsForm(QWidget):
    """The first and the last end of an obstacle; an end that is no place is kept until the user changes it.

    edited: `first` or `last`, the end that the user changed, or an empty text if both are random or fixed now.
    """

    edited = Signal(str)

    def __init__(self) -> None:
        super().__init__()
        self.default_ends = named(QCheckBox(), "default_ends")
        self.coordinates = [Coordinate(title) for title in ("X first", "Y first", "X last", "Y last")]
        self._given: Entry = {}
        self._shown = self._read()
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(self.default_ends)
        grid = QGridLayout()
        column.addLayout(grid)
        for number, coordinate in enumerate(self.coordinates):
            grid.addWidget(coordinate, number // 2, number % 2)
            end = "first" if number < 2 else "last"
            coordinate.edited.connect(lambda end=end: self.edited.emit(end))
        self.default_ends.toggled.connect(self._toggled)

    def value(self) -> Entry:
        """The ends as a recipe file has them; none for the default ends."""
        read = self._read()
        found = {end: self._given.get(end) if place == self._shown[end] else place for end, place in read.items()}
        return {end: place for end, place in found.items() if place is not None}

    def inside(self, grid: Grid) -> Entry:
        """The ends, moved to the edge of a map if they are beyond it."""
        return {end: _inside(place, grid) for end, place in self.value().items()}

    def show_entry(self, entry: Entry, grid: Grid) -> None:
        """Show the ends of an obstacle in a map of this size, without a signal."""
        blocker = QSignalBlocker(self.default_ends)
        self.default_ends.setChecked("first" not in entry and "last" not in entry)
        del blocker
        ends = [*_pair(entry.get("first"), (0, 0)), *_pair(entry.get("last"), (grid.n_x - 1, grid.n_y - 1))]
        for coordinate, value, cells in zip(self.coordinates, ends, grid.shape * 2, strict=True):
            coordinate.show_value(value, cells)
        self._given, self._shown = entry, self._read()
        self._show_coordinates()

    def _read(self) -> dict[str, Json]:
        if self.default_ends.isChecked():
            return {"first": None, "last": None}
        x1, y1, x2, y2 = (coordinate.value() for coordinate in self.coordinates)
        return {"first": [x1, y1], "last": [x2, y2]}

    def _toggled(self) -> None:
        self._show_coordinates()
        self.edited.emit("")

    def _show_coordinates(self) -> None:
        for coordinate in self.coordinates:
            coordinate.setVisible(not self.default_ends.isChecked())


def _pair(place: Json, default: tuple[int, int]) -> list[Json]:
    """Both coordinates of a place; those of the default if it has not two."""
    if place == "random":
        return ["random", "random"]
    return list(place) if isinstance(place, (list, tuple)) and len(place) == 2 else list(default)


def _inside(place: Json, grid: Grid) -> Json:
    if not isinstance(place, list) or len(place) != 2:
        return place
    return [min(at, cells - 1) if isinstance(at, int) else at for at, cells in zip(place, grid.shape, strict=True)]
