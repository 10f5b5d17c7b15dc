"""The left half of the window: the forms of the map and of one obstacle, messages, and Start."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QPushButton, QTabWidget, QVBoxLayout, QWidget

from rsegen.gui.model.document import Document
from rsegen.gui.model.typed_cells import kind_words, problem_text
from rsegen.gui.widgets.layouts import Scrolled, group_of
from rsegen.gui.widgets.map_form import BASIC, MapForm
from rsegen.gui.widgets.message_label import MessageLabel, PassingNote
from rsegen.gui.widgets.more_form import MoreForm
from rsegen.gui.widgets.named import named
from rsegen.gui.widgets.obstacle_form import ObstacleForm
from rsegen.gui.widgets.start_form import StartForm


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
