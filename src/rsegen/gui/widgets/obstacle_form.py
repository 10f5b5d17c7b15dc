"""The form of an obstacle: kind, parameters, and sliders for its ends, as in the paper's window."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import MISSING
from itertools import pairwise

from PySide6.QtCore import QSignalBlocker, QSize, Qt, Signal
from PySide6.QtGui import QIcon
from PySide6.QtWidgets import (
    QAbstractSpinBox,
    QCheckBox,
    QComboBox,
    QFormLayout,
    QGridLayout,
    QLabel,
    QSlider,
    QVBoxLayout,
    QWidget,
)

from rsegen.errors import RsegenError
from rsegen.exporters.scene import compose
from rsegen.field.obstacles import KINDS, Grid, Obstacle
from rsegen.field.obstacles.base import PLACING, own_parameters
from rsegen.gui.model.obstacle_ends import aligned, kind_words, shifted
from rsegen.gui.model.session import Entry
from rsegen.gui.widgets.editors import Editor, IntegerBox, SliderEditor, editor, shortened
from rsegen.gui.widgets.layouts import named, scroll_past
from rsegen.gui.widgets.plan_painting import square_icon
from rsegen.params.registry import summary
from rsegen.params.sorts import Json
from rsegen.recipe.codec import decode

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


SIDE = 32
"""The side of a picture in pixels."""


class KindBox(QComboBox):
    """Chooses a kind by its name in plain words; `chosen` is emitted when the user chooses another."""

    chosen = Signal()

    def __init__(self) -> None:
        super().__init__()
        named(self, "kind", title="obstacle type", tip="what the obstacle looks like")
        scroll_past(self)
        self.setIconSize(QSize(SIDE, SIDE))
        for kind, cls in KINDS.items():
            self.addItem(_picture(kind), kind_words(kind), kind)
            self.setItemData(self.count() - 1, summary(cls), Qt.ItemDataRole.ToolTipRole)
        self.currentIndexChanged.connect(lambda: self.chosen.emit())

    @property
    def kind(self) -> str:
        """The kind that is chosen; empty if an unknown one is shown."""
        return self.currentData() or ""

    def show_kind(self, kind: Json) -> None:
        """Show a kind without a signal; an unknown one as its text."""
        blocker = QSignalBlocker(self)
        self.setPlaceholderText(shortened(kind))
        self.setCurrentIndex(self.findData(kind))
        del blocker


def _picture(kind: str) -> QIcon:
    """A pallet with one obstacle of a kind; no picture of a plug-in's kind that needs more than its defaults."""
    row = {"kind": kind, "levels": 5}
    try:
        scene = compose(decode({"seed": 3, "boundary": "none", "obstacles": [row]}), 0)
    except RsegenError:
        return QIcon()
    return square_icon(scene, SIDE)


DEFAULT = {"kind": "horizontal_barrier", "levels": 5, "softness": 0}

SLIDERS = {"levels": 20, "softness": 100}
"""The parameters that have a slider, and where it ends."""

BLENDS = {
    "replace": "This obstacle overwrites the earlier ones.",
    "max": "The higher one counts: this obstacle or the earlier ones.",
    "add": "This obstacle is put on top of the earlier ones.",
    "min": "The lower one counts: this obstacle cuts into the earlier ones.",
}

_LISTED = 12


class ObstacleForm(QWidget):
    """Edits one obstacle as an entry of a recipe file; `edited` is emitted when the user changes it.

    Values that it cannot show, such as those typed into the list, are kept until the user changes them.
    fixed: gives an entry with fixed ends, for one whose ends were random until now.
    """

    edited = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.fixed: Callable[[Entry], Entry] = lambda entry: entry
        self.kind = KindBox()
        self.kind.chosen.connect(self._change_kind)
        self.ends = EndsForm()
        self.ends.edited.connect(self._move_end)
        self.default_ends = self.ends.default_ends
        self._about = _words("about_kind")
        self._editors: dict[str, Editor] = {}
        self._fields = QFormLayout(verticalSpacing=3)
        self._lay_out()
        self._given: Entry = DEFAULT
        self._grid, self._unit = Grid(10, 10, 10), 10.0
        self.show_entry(DEFAULT, self._grid, self._unit)

    def entry(self) -> dict[str, Json]:
        """The obstacle in the form, as a recipe file has it."""
        values = {name: each.value() for name, each in self._editors.items()}
        found = {name: value for name, value in values.items() if value is not None}
        if self.kind.kind:
            return {"kind": self.kind.kind, **found, **self.ends.value()}
        others = {name: value for name, value in self._given.items() if name not in {*values, "first", "last"}}
        return {**others, **found, **self.ends.value()}

    def show_entry(self, entry: Entry, grid: Grid, unit_cm: float) -> None:
        """Show an obstacle without a signal; of an unknown kind, typed into the list, what all kinds have."""
        self._given, self._grid, self._unit = entry, grid, unit_cm
        self.kind.show_kind(entry["kind"])
        self._make_fields()
        for name, each in self._editors.items():
            each.show_value(entry.get(name, _default(self._class, name)))
        self.ends.show_entry(entry, grid)
        self._describe()

    def show_map(self, grid: Grid, unit_cm: float) -> None:
        """Show the size and the unit of a map; ends beyond it are moved to its edge."""
        self.show_entry({**self.entry(), **self.ends.inside(grid)}, grid, unit_cm)

    def reset(self) -> None:
        """Show the obstacle of a new window."""
        self.show_entry(DEFAULT, self._grid, self._unit)

    def finish_typing(self) -> None:
        """Take over a text that was typed and not yet finished with Enter."""
        for each in list(self._editors.values()):
            each.finish_typing()

    @property
    def _class(self) -> type[Obstacle]:
        """The class of the kind; of an unknown kind what all have in common."""
        return KINDS.get(self.kind.kind, Obstacle)

    def _lay_out(self) -> None:
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        top = QFormLayout()
        top.addRow("Obstacle type", self.kind)
        column.addLayout(top)
        column.addWidget(self._about)
        column.addLayout(self._fields)
        column.addWidget(self.ends)

    def _make_fields(self) -> None:
        """Replace the fields if another kind is chosen."""
        cls = self._class
        sorts = {**own_parameters(cls), "blend": PLACING["blend"]}
        if sorts == {name: each.parameter for name, each in self._editors.items()}:
            return
        while self._fields.rowCount():
            _remove_later(self._fields.takeRow(0))
        self._editors, self._heights, self._blend = {}, _words("heights"), _words("about_blend")
        for name, sort in sorts.items():
            most = SLIDERS.get(name)
            each = SliderEditor(name, sort, most) if most else editor(cls, name)
            self._editors[name] = each
            each.edited.connect(self._emit)
            self._fields.addRow(name.replace("_", " ").capitalize(), each)
            if below := {"levels": self._heights, "blend": self._blend}.get(name):
                self._fields.addRow("", below)
        _tab_through(self.kind, *(field for each in self._editors.values() for field in each.fields), self.default_ends)

    def _move_end(self, end: str) -> None:
        """Straighten an obstacle one of whose ends was moved, or fix ends that were random."""
        entry = self.entry()
        if not end and not self.default_ends.isChecked():
            rest = {name: value for name, value in entry.items() if name not in {"first", "last"}}
            entry = dict(self.fixed(rest))
        elif end:
            entry = dict(shifted(self._given, entry, end))
        if entry != self.entry():
            self.ends.show_entry(entry, self._grid)
        self._emit()

    def _change_kind(self) -> None:
        entry = self.entry()
        self.show_entry(aligned(entry, "last"), self._grid, self._unit)
        self.edited.emit()

    def _emit(self) -> None:
        self._describe()
        self.edited.emit()

    def _describe(self) -> None:
        self._about.setText(summary(self._class).replace("`", "") if self.kind.kind else "")
        self._blend.setText(BLENDS.get(str(self._editors["blend"].value()), ""))
        self.default_ends.setText(self._class.default_place)
        top, softness = (self._editors[name].value() for name in ("levels", "softness"))
        levels = (
            f"{top} level{'s'[: top != 1]}: {_heights(top, self._unit)} cm" if isinstance(top, int) and top > 0 else ""
        )
        self._heights.setText(levels + ", before softness" * bool(levels and softness))


def _words(name: str) -> QLabel:
    return named(QLabel(wordWrap=True), name)


def _remove_later(row: QFormLayout.TakeRowResult) -> None:
    """Take the widgets of a row out, and delete them when Qt is done with them: one may be about to get the focus."""
    for item in (row.labelItem, row.fieldItem):
        if widget := item and item.widget():  # some rows have no label
            widget.hide()
            widget.setParent(None)
            widget.deleteLater()


def _tab_through(*widgets: QWidget) -> None:
    for one, next_ in pairwise(widgets):
        QWidget.setTabOrder(one, next_)


def _heights(top: int, unit_cm: float) -> str:
    """The heights of the levels in centimetres; of many, the lowest."""
    return ", ".join([f"{level * unit_cm:g}" for level in range(min(top, _LISTED))] + ["..."] * (top > _LISTED))


def _default(cls: type[Obstacle], name: str) -> Json:
    """The default of a parameter; None if it has none."""
    default = cls.__dataclass_fields__[name].default
    return None if default is MISSING else default
