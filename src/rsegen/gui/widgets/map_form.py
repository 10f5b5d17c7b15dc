"""The form of the global parameters, generated from `Recipe`, with errors under their fields."""

from __future__ import annotations

from collections.abc import Iterable

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QCheckBox, QFormLayout, QHBoxLayout, QLabel, QPushButton, QWidget

from rsegen.errors import ParameterError
from rsegen.gui.model.session import Entry
from rsegen.gui.widgets.editors import Editor, editor
from rsegen.gui.widgets.layouts import row_of
from rsegen.gui.widgets.message_label import MessageLabel
from rsegen.gui.widgets.named import named
from rsegen.params.sorts import parameters
from rsegen.recipe.recipe import Recipe

BASIC = ("maps", "chunk_size", "chunks", "unit_cm", "boundary", "mesh_type", "seed")
"""The parameters of the first tab: the paper's, and the seed."""

KEEP = """Ticked: Start writes the maps that are shown, with this seed.
Not ticked: every Start draws another seed first, which is shown and can be undone.
Re-roll draws another seed at once."""

TITLES = {
    "maps": "Number of maps",
    "chunk_size": "Chunk size",
    "chunks": "Map size in chunks",
    "unit_cm": "Height step (unit)",
    "boundary": "Chunk boundary",
    "mesh_type": "Model mesh type",
}


class MapForm(QWidget):
    """A field for each of some global parameters; `edited` gives name and value, `reroll` asks for another seed."""

    edited = Signal(str, object)
    reroll = Signal()

    def __init__(self, names: Iterable[str]) -> None:
        super().__init__()
        self._editors: dict[str, Editor] = {}
        self._error_labels: dict[str, MessageLabel] = {}
        self.keep = named(QCheckBox("Keep"), "keep_seed", title="keep the seed at Start", tip=KEEP)
        self._form = QFormLayout(self)
        self._form.setVerticalSpacing(3)
        for name in names:
            self._add(name)

    def show_values(self, values: Entry, problem: ParameterError | None) -> None:
        """Show the values of a draft, and its problem under the field that caused it."""
        for name, each in self._editors.items():
            each.show_value(values.get(name))
            about = problem and problem.where.partition("[")[0] == name
            self._error_labels[name].show_message(problem.problem if problem and about else "")

    def finish_typing(self) -> None:
        """Take over a text that was typed and not yet finished with Enter."""
        for each in self._editors.values():
            each.finish_typing()

    def show_matching(self, text: str) -> bool:
        """Show only the parameters whose name or help contains a text; whether there are any."""
        found = [name for name in self._editors if text.lower() in f"{_title(name)} {self._help(name)}".lower()]
        for name, each in self._editors.items():
            self._form.setRowVisible(each, name in found)
            self._form.setRowVisible(self._error_labels[name], name in found and bool(self._error_labels[name].text()))
        return bool(found)

    def _help(self, name: str) -> str:
        return f"{name} {parameters(Recipe)[name].help}"

    def _add(self, name: str) -> None:
        each, error_label = editor(Recipe, name), MessageLabel(f"{name}_error")
        each.edited.connect(lambda value: self.edited.emit(name, value))
        self._editors[name], self._error_labels[name] = each, error_label
        label = QLabel(_title(name))
        label.setBuddy(each)
        self._form.addRow(label, each)
        if name == "seed":
            self._form.addRow("", self._seed_buttons())
        self._form.addRow(error_label)

    def _seed_buttons(self) -> QHBoxLayout:
        """Below the seed, so that its up to 19 digits are seen."""
        dice = named(QPushButton("Re-roll"), "reroll", tip="draw another seed (Ctrl+R)")
        dice.clicked.connect(self.reroll)
        row = row_of(self.keep, dice)
        row.addStretch(1)
        return row


def _title(name: str) -> str:
    return TITLES.get(name, name.replace("_cm", "").replace("_", " ").capitalize())
