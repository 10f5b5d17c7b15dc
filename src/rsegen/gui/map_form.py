"""The form of the global parameters, made from `Recipe`; an error stands under the field that caused it."""

from __future__ import annotations

from collections.abc import Iterable

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QCheckBox, QFormLayout, QHBoxLayout, QLabel, QPushButton, QWidget

from rsegen.errors import ParameterError
from rsegen.gui.editors import Editor, editor, named
from rsegen.gui.notice import Notice
from rsegen.gui.session import Entry
from rsegen.params.sorts import parameters
from rsegen.recipe.recipe import Recipe

OFTEN = ("maps", "chunk_size", "chunks", "unit_cm", "boundary", "mesh_type", "seed")
"""The paper's parameters, and the seed."""

SELDOM = tuple(name for name in parameters(Recipe) if name not in OFTEN)

KEEP = """Kept: Start writes the maps that are shown, with this seed.
Not kept: every Start draws another seed first; it is shown, and can be undone.
Re-roll draws another seed at once, either way."""

TITLES = {
    "maps": "Number of maps",
    "chunk_size": "Chunk size",
    "chunks": "Map size in chunks",
    "unit_cm": "Height step (unit)",
    "boundary": "Chunk boundary",
    "mesh_type": "Model mesh type",
}


class MapForm(QWidget):
    """Some of the global parameters; `edited` tells a name and a value."""

    edited = Signal(str, object)
    reroll = Signal()

    def __init__(self, names: Iterable[str]) -> None:
        super().__init__()
        self._editors: dict[str, Editor] = {}
        self._complaints: dict[str, Notice] = {}
        self.keep = named(QCheckBox("Keep"), "keep_seed", title="keep the seed at Start", tip=KEEP)
        self._form = QFormLayout(self)
        self._form.setVerticalSpacing(3)
        for name in names:
            self._add(name)

    def show_values(self, values: Entry, problem: ParameterError | None) -> None:
        """Put the values of a draft into the fields, and what is wrong under the one that it is about."""
        for name, each in self._editors.items():
            each.show_value(values.get(name))
            about = problem and problem.where.partition("[")[0] == name
            self._complaints[name].say(problem.problem if problem and about else "")

    def _add(self, name: str) -> None:
        each, complaint = editor(Recipe, name), Notice(f"{name}_complaint")
        each.edited.connect(lambda value: self.edited.emit(name, value))
        self._editors[name], self._complaints[name] = each, complaint
        label = QLabel(TITLES.get(name, name.replace("_cm", "").replace("_", " ").capitalize()))
        label.setBuddy(each)
        self._form.addRow(label, self._with_dice(each) if name == "seed" else each)
        self._form.addRow(complaint)

    def _with_dice(self, each: Editor) -> QWidget:
        row, dice = QWidget(), named(QPushButton("Re-roll"), "reroll", tip="draw another seed (Ctrl+R)")
        dice.clicked.connect(self.reroll)
        box = QHBoxLayout(row)
        box.setContentsMargins(0, 0, 0, 0)
        for widget in (each, self.keep, dice):
            box.addWidget(widget)
        return row
