"""The left half of the window: the forms of the map and of an obstacle, messages, and Start."""

from __future__ import annotations

from collections.abc import Iterable

from PySide6.QtCore import Signal
from PySide6.QtWidgets import (
    QCheckBox,
    QFormLayout,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QPushButton,
    QTabWidget,
    QVBoxLayout,
    QWidget,
)

from rsegen.errors import ParameterError
from rsegen.gui.model.document import Document
from rsegen.gui.model.jobs import WorldsJob
from rsegen.gui.model.obstacle_ends import kind_words, problem_text
from rsegen.gui.model.session import Entry
from rsegen.gui.widgets.editors import Editor, editor
from rsegen.gui.widgets.layouts import MessageLabel, PassingNote, Scrolled, group_of, named, row_of
from rsegen.gui.widgets.obstacle_form import ObstacleForm
from rsegen.gui.widgets.run_form import FormTexts, RunForm
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


_TEXTS = FormTexts("folder", "worlds", "maps", "Start", "write the maps into the folder (F5)")


class StartForm(RunForm):
    """Writes worlds, with build sheets if their box is ticked."""

    def __init__(self) -> None:
        tip = "add a build sheet to every map, sheet.pdf and sheet.csv: the cutting list, and the place of each block"
        sheets = named(QCheckBox("Build sheets"), "sheets", tip=tip)
        tip = "write the maps for other programs: meshes, arrays, images and more (Ctrl+Shift+E)"
        export = named(QPushButton("Export..."), "export", tip=tip)
        tip = "open the map that is shown in a simulator"
        self.open_in = named(QPushButton("Open in Gazebo..."), "open_in", title="open in Gazebo", tip=tip)
        tip = "spawn the map that is shown in the running simulation (F6)"
        self.spawn = named(QPushButton("Send"), "spawn", title="send to the running simulation", tip=tip)
        super().__init__(_TEXTS, sheets, export, afterwards=(self.open_in, self.spawn))
        self.sheets, self.export = sheets, export
        sheets.toggled.connect(lambda: self.error_label.show_message(""))

    def job(self, recipe: Recipe) -> WorldsJob:
        """The job that Start runs for a recipe."""
        return WorldsJob(recipe=recipe, folder=self.folder, sheets=self.sheets.isChecked())


class RecipeForms(QWidget):
    """Shows a document in forms.

    edited: a global parameter has another value; reroll: another seed is asked for. The buttons and the obstacle form
    have signals of their own.
    """

    edited = Signal(str, object)
    reroll = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.basic, self.advanced, self.obstacle = MapForm(BASIC), MoreForm(), ObstacleForm()
        tip = "edit a new obstacle in place of the selected one (Escape)"
        self.another = named(QPushButton("New obstacle"), "another", title="new obstacle", tip=tip)
        self.start_form = StartForm()
        self.start = self.start_form.start
        self.error_label, self.warning = MessageLabel("error"), MessageLabel("warning", "warning")
        self.note = PassingNote()
        self.basic.edited.connect(self.edited)
        self.advanced.edited.connect(self.edited)
        self.basic.reroll.connect(self.reroll)
        self._problem, self._failure, self._selected = "", "", -1
        self._lay_out()

    def show_document(self, document: Document) -> None:
        """Show the parameters and the selected obstacle of a document, and what is wrong with it."""
        draft, problem, recipe = document.session.draft, document.session.problem, document.session.recipe
        for form in (self.basic, self.advanced):
            form.show_values(draft.values, problem)
        if document.selected >= 0 and document.selected != self._selected:
            self.tabs.setCurrentIndex(0)
        self._selected = document.selected
        if entry := document.selected_entry:
            self.obstacle.show_entry(entry, recipe.grid, recipe.unit_cm)
            self._group.setTitle(f"Obstacle {document.selected + 1}: {kind_words(str(entry['kind']))}")
        else:
            self.obstacle.show_map(recipe.grid, recipe.unit_cm)
            self._group.setTitle("New obstacle")
        self.another.setVisible(document.selected >= 0)
        self._problem = problem_text(problem)
        self._show_error()
        for button in (self.start, self.start_form.export, self.start_form.spawn, self.start_form.open_in):
            button.setEnabled(problem is None)

    def show_failure(self, text: str) -> None:
        """Show why there is no preview, unless the document has a problem; an empty text if there is one."""
        self._failure = text
        self._show_error()

    def finish_typing(self) -> None:
        """Take over a text that was typed into a field and not yet finished with Enter."""
        for form in (self.basic, self.advanced, self.obstacle):
            form.finish_typing()

    def show_warnings(self, warnings: tuple[str, ...]) -> None:
        """Show warnings about the map; none hides the label."""
        self.warning.show_message("\n".join(f"Warning: {text}" for text in warnings))

    def _show_tab(self, number: int) -> None:
        """The second tab takes the place of the obstacle's form too."""
        self._group.setVisible(number == 0)
        self._column.setStretchFactor(self.tabs, number)
        self._column.setStretch(2, 1 - number)

    def _show_error(self) -> None:
        self.error_label.show_message(self._problem or self._failure)

    def _lay_out(self) -> None:
        """The forms scroll; messages and Start stay in view."""
        forms = QWidget()
        self._column = column = QVBoxLayout(forms)
        self._group = group_of("New obstacle", self.another, self.obstacle)
        self.tabs = tabs = named(QTabWidget(), "tabs", title="parameters of the map")
        tabs.addTab(self.basic, "Map")
        tabs.addTab(self.advanced, "More")
        column.addWidget(tabs)
        column.addWidget(self._group)
        column.addStretch(1)
        tabs.currentChanged.connect(self._show_tab)
        stack = QVBoxLayout(self)
        stack.setContentsMargins(0, 0, 0, 0)
        stack.addWidget(Scrolled(forms), stretch=1)
        for part in (self.warning, self.error_label, self.note, self.start_form):
            stack.addWidget(part)
        for label in (self.warning, self.error_label, self.note):
            label.setContentsMargins(10, 0, 10, 0)
