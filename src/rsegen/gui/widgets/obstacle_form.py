"""The form of one obstacle: kind, parameters, and four sliders for its ends, as in the paper's window."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import MISSING
from itertools import pairwise

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QFormLayout, QLabel, QVBoxLayout, QWidget

from rsegen.field.obstacles import KINDS, Grid, Obstacle
from rsegen.gui.model.ends import aligned, shifted
from rsegen.gui.model.session import Entry
from rsegen.gui.widgets.editors import Editor, editor
from rsegen.gui.widgets.ends_form import EndsForm
from rsegen.gui.widgets.kind_box import KindBox
from rsegen.gui.widgets.named import named
from rsegen.gui.widgets.slider_editor import SliderEditor
from rsegen.params.registry import summary
from rsegen.params.sorts import Json, parameters
from rsegen.recipe.recipe import Placement

DEFAULT = {"kind": "horizontal_barrier", "max_height": 5, "softness": 0}

SLIDERS = {"max_height": 20, "softness": 100}
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
        sorts = {**parameters(cls), "blend": parameters(Placement)["blend"]}
        if sorts == {name: each.parameter for name, each in self._editors.items()}:
            return
        while self._fields.rowCount():
            _remove_later(self._fields.takeRow(0))
        self._editors, self._heights, self._blend = {}, _words("heights"), _words("about_blend")
        for name, sort in sorts.items():
            most = SLIDERS.get(name)
            each = SliderEditor(name, sort, most) if most else editor(_owner(cls, name), name)
            self._editors[name] = each
            each.edited.connect(self._emit)
            self._fields.addRow(name.replace("_", " ").capitalize(), each)
            if below := {"max_height": self._heights, "blend": self._blend}.get(name):
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
        top, softness = (self._editors[name].value() for name in ("max_height", "softness"))
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


def _owner(cls: type[Obstacle], name: str) -> type:
    return cls if name in parameters(cls) else Placement


def _default(cls: type[Obstacle], name: str) -> Json:
    """The default of a parameter; None if it has none."""
    default = {**cls.__dataclass_fields__, **Placement.__dataclass_fields__}[name].default
    return None if default is MISSING else default
