"""What is true of the window whatever was done to it."""

from __future__ import annotations

from collections.abc import Iterator

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QApplication, QLabel, QLineEdit

from rsegen.errors import ParameterError
from rsegen.gui.model.obstacle_ends import cell_text, problem_text
from rsegen.gui.model.session import Draft, Session
from rsegen.gui.widgets.obstacle_table import KEYS
from rsegen.gui.window import Window


def broken(window: Window) -> Iterator[str]:
    """What is not as it should be, as texts."""
    yield from _problem(window)
    yield from _list(window)
    yield from _forms(window)
    yield from _messages(window)
    session = window.session
    actions = {action.objectName(): action.isEnabled() for action in window.findChildren(QAction)}
    if (actions["Undo"], actions["Redo"]) != (session.can_undo, session.can_redo):
        yield "Undo and Redo are not enabled as they should be"
    plan = window.views.plan
    if plan.cells and list(plan._handles) != window.document.handles(plan.cells):
        yield "the ends on the plan are not those of the obstacles"


def history_broken(session: Session, first: Draft) -> Iterator[str]:
    """Whether undo leads to the first draft, and redo back to the last."""
    last, steps = session.draft, len(session._done)
    for _ in range(steps):
        session.undo()
    if session.can_undo:
        yield f"undo adds changes to the history; one leads to {session.draft}"
    elif session.draft != first:
        yield f"undo leads to {session.draft}, and the first was {first}"
    for _ in range(steps):
        session.redo()
    if session.draft != last:
        yield f"redo leads to {session.draft}, and the last was {last}"


def preview_broken(window: Window) -> Iterator[str]:
    """Whether the map that is shown, once nothing changes, is that of the recipe, or an error is shown."""
    scene, wanted = window.previewer.scene, (window.session.recipe, window.status.shown_index())
    if window.forms.error_label.isHidden() and (scene is None or (scene.recipe, scene.index) != wanted):
        yield f"the preview is not that of map {wanted[1]}"


def _problem(window: Window) -> Iterator[str]:
    """The recipe is valid and is that of the draft, or an error is shown."""
    session, label = window.session, window.forms.error_label
    try:
        recipe = session.draft.recipe()
    except ParameterError as error:
        if str(session.problem) != str(error) or label.text() != problem_text(error) or label.isHidden():
            yield f"{error} is not shown, but {label.text()!r}"
        if window.forms.start.isEnabled() or window.outputs.is_possible:
            yield f"can be started though {error}"
        return
    if session.problem or session.recipe != recipe:
        yield f"the recipe is not that of the draft; {session.problem}"


def _list(window: Window) -> Iterator[str]:
    """The list shows the rows of the session; a cell that is being edited aside."""
    table, rows = window.views.table, window.session.draft.rows
    if table.rowCount() != len(rows):
        yield f"the list has {table.rowCount()} rows of {len(rows)}"
        return
    if table.selected != window.document.selected:
        yield f"row {table.selected} of the list is selected, and {window.document.selected} of the document"
    for number, row in enumerate(rows):
        texts = [item.text() if (item := table.item(number, column)) else None for column in range(len(KEYS))]
        wanted = [cell_text(row.entry, key) if key else str(number + 1) for key in KEYS]
        if texts != wanted:
            yield f"row {number} of the list shows {texts}, and is {wanted}"
        box = table.item(number, 0)
        if box is None or (box.checkState() == Qt.CheckState.Checked) != row.enabled:
            yield f"the box of row {number} is not {row.enabled}"


def _forms(window: Window) -> Iterator[str]:
    """The forms show the draft; fields in which a text was typed and not finished aside."""
    draft, document = window.session.draft, window.document
    for form in (window.forms.basic, *window.forms.advanced.groups.values()):
        for name, each in form._editors.items():
            unfinished = isinstance(each.fields[0], QLineEdit) and each.fields[0].isModified()
            if not unfinished and each.value() != draft.values.get(name):
                yield f"{name} shows {each.value()!r}, and is {draft.values.get(name)!r}"
    if entry := document.selected_entry:
        shown = window.forms.obstacle.entry()
        for name in ("kind", "levels", "first", "last"):
            if shown.get(name) != entry.get(name):
                yield f"the form shows {name} {shown.get(name)!r}, and it is {entry.get(name)!r}"


def _messages(window: Window) -> Iterator[str]:
    """Nothing that is shown is a mistake in rsegen."""
    labels = [label.text() for top in QApplication.topLevelWidgets() for label in top.findChildren(QLabel)]
    for text in labels:
        if "internal error" in text or "Traceback" in text:
            yield text
