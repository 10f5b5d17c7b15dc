"""The second tab: all other parameters of the map in groups, with a filter."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QLineEdit, QVBoxLayout, QWidget

from rsegen.errors import ParameterError
from rsegen.gui.model.session import Entry
from rsegen.gui.widgets.layouts import Scrolled, group_of
from rsegen.gui.widgets.map_form import BASIC, MapForm
from rsegen.gui.widgets.named import named
from rsegen.params.sorts import parameters
from rsegen.recipe.recipe import Recipe

_GROUPS = {
    "Shape": ("block_width_cm", "frame_height_cm", "difficulty"),
    "Constraints": ("max_step", "crossable_by", "inventory"),
    "Files and simulator": ("name", "description", "first_map", "simulator", "mesh", "collision", "tile"),
    "Friction": ("friction", "frame_friction", "level_friction"),
    "Look": ("look", "frame_colour", "level_colours", "shadows", "sky"),
}
"""The titles of the groups and their parameters; a parameter that no group has is in the last one, Other."""


class MoreForm(QWidget):
    """`edited` gives name and value of a parameter that was changed."""

    edited = Signal(str, object)

    def __init__(self) -> None:
        super().__init__()
        tip = "show only the parameters whose name or help contains this text"
        self._filter = named(QLineEdit(clearButtonEnabled=True), "filter", title="filter of the parameters", tip=tip)
        self._filter.setPlaceholderText("filter")
        self.groups = {title: MapForm(names) for title, names in _groups().items()}
        self._boxes = {title: group_of(title, form) for title, form in self.groups.items()}
        content = QWidget()
        column = QVBoxLayout(content)
        for box in self._boxes.values():
            column.addWidget(box)
        column.addStretch(1)
        whole = QVBoxLayout(self)
        whole.addWidget(self._filter)
        whole.addWidget(Scrolled(content))
        for form in self.groups.values():
            form.edited.connect(self.edited)
        self._filter.textChanged.connect(self._show_matching)

    def show_values(self, values: Entry, problem: ParameterError | None) -> None:
        """Show the values of a draft, and its problem under the field that caused it."""
        for form in self.groups.values():
            form.show_values(values, problem)

    def finish_typing(self) -> None:
        """Take over a text that was typed and not yet finished with Enter."""
        for form in self.groups.values():
            form.finish_typing()

    def _show_matching(self, text: str) -> None:
        for title, form in self.groups.items():
            self._boxes[title].setVisible(form.show_matching(text))


def _groups() -> dict[str, tuple[str, ...]]:
    """Every parameter that the first tab has not, in a group."""
    grouped = {name for names in _GROUPS.values() for name in names}
    others = tuple(name for name in parameters(Recipe) if name not in {*BASIC, *grouped})
    return _GROUPS | ({"Other": others} if others else {})
