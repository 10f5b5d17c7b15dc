"""The left half of the window: the forms of the map and of one obstacle, messages, and Start."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QPushButton, QTabWidget, QVBoxLayout, QWidget

from rsegen.gui.model.document import Document
from rsegen.gui.widgets.layouts import Scrolled, group_of, row_of
from rsegen.gui.widgets.map_form import ADVANCED, BASIC, MapForm
from rsegen.gui.widgets.message_label import MessageLabel
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
        self.basic, self.advanced, self.obstacle = MapForm(BASIC), MapForm(ADVANCED), ObstacleForm()
        self.add = named(QPushButton("+"), "add", title="add obstacle", tip="add this obstacle (Ctrl+Return)")
        self.remove = named(QPushButton("-"), "remove", title="remove last obstacle", tip="remove the last obstacle")
        self.clear = named(QPushButton("C"), "clear", title="clear all obstacles", tip="remove all obstacles")
        self.start_form = StartForm()
        self.start = self.start_form.start
        self.error_label, self.warning = MessageLabel("error"), MessageLabel("warning", "warning")
        for form in (self.basic, self.advanced):
            form.edited.connect(self.edited)
            form.reroll.connect(self.reroll)
        self._problem, self._failure = "", ""
        self._lay_out()

    def show_document(self, document: Document) -> None:
        """Show the parameters and the selected obstacle of a document, and what is wrong with it."""
        draft, problem, recipe = document.session.draft, document.session.problem, document.session.recipe
        for form in (self.basic, self.advanced):
            form.show_values(draft.values, problem)
        if entry := document.selected_entry:
            self.obstacle.show_entry(entry, recipe.grid, recipe.unit_cm)
        else:
            self.obstacle.show_map(recipe.grid, recipe.unit_cm)
        self._problem = str(problem) if problem else ""
        self._show_error()
        for button in (self.start, self.start_form.export):
            button.setEnabled(problem is None)
        for button in (self.remove, self.clear):
            button.setEnabled(bool(draft.rows))

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

    def _show_error(self) -> None:
        self.error_label.show_message(self._problem or self._failure)

    def _lay_out(self) -> None:
        """The forms scroll; messages and Start stay in view."""
        forms = QWidget()
        column = QVBoxLayout(forms)
        tabs = named(QTabWidget(), "tabs", title="parameters of the map")
        tabs.addTab(self.basic, "Map")
        tabs.addTab(Scrolled(self.advanced), "More")
        column.addWidget(tabs)
        column.addWidget(group_of("Obstacle", self.obstacle, row_of(self.add, self.remove, self.clear)))
        column.addStretch(1)
        stack = QVBoxLayout(self)
        stack.setContentsMargins(0, 0, 0, 0)
        stack.addWidget(Scrolled(forms), stretch=1)
        for part in (self.warning, self.error_label, self.start_form):
            stack.addWidget(part)
        for label in (self.warning, self.error_label):
            label.setContentsMargins(10, 0, 10, 0)
