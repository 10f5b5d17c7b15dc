"""The menus of the window, and what they start."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtGui import QAction, QKeySequence
from PySide6.QtWidgets import QFileDialog, QMenu

from rsegen.gui.example_dialog import ExampleDialog
from rsegen.gui.export_dialog import ExportDialog
from rsegen.gui.files import choose_dataset, choose_file, choose_heights, fill_recent, replace_session, save, save_as
from rsegen.gui.manual import show_manual
from rsegen.gui.session import Session
from rsegen.gui.sheet_dialog import SheetDialog
from rsegen.gui.spelled_dialog import SpelledDialog

if TYPE_CHECKING:
    from rsegen.gui.window import Window


def add_menus(window: Window) -> None:
    """File, Edit, View, Run and Help."""
    files = window.menuBar().addMenu("&File")
    _act(window, files, "&New", lambda: replace_session(window, Session.new), QKeySequence.StandardKey.New)
    _act(window, files, "New from &example...", partial(choose_example, window), "Ctrl+Shift+N")
    _act(window, files, "&Open...", partial(choose_file, window), QKeySequence.StandardKey.Open)
    _act(window, files, "Open a map of a &data set...", partial(choose_dataset, window), "Ctrl+Shift+O")
    recent = files.addMenu("Open &recent")
    recent.aboutToShow.connect(partial(fill_recent, window, recent))
    _act(window, files, "Read &heights...", partial(choose_heights, window), "Ctrl+I")
    _act(window, files, "&Save", partial(save, window), QKeySequence.StandardKey.Save)
    _act(window, files, "Save &as...", partial(save_as, window), QKeySequence.StandardKey.SaveAs)
    _act(window, files, "&Quit", window.close, QKeySequence.StandardKey.Quit)
    edit = window.menuBar().addMenu("&Edit")
    _act(window, edit, "&Undo", lambda: window.session.undo(), QKeySequence.StandardKey.Undo)
    _act(window, edit, "&Redo", lambda: window.session.redo(), QKeySequence.StandardKey.Redo)
    edit.addSeparator()
    _act(window, edit, "&Add obstacle", window.add_obstacle, "Ctrl+Return")
    _act(window, edit, "&Duplicate obstacle", partial(_with_row, window, _duplicate), "Ctrl+D")
    _act(window, edit, "Re&move obstacle", partial(_with_row, window, _remove), QKeySequence.StandardKey.Delete)
    _act(window, edit, "Move obstacle u&p", partial(_with_row, window, partial(_shift, by=-1)), "Alt+Up")
    _act(window, edit, "Move obstacle d&own", partial(_with_row, window, partial(_shift, by=1)), "Alt+Down")
    _act(window, edit, "&Paint cells", window.brushes.taken.toggle, "P")
    _act(window, edit, "Re-&roll the seed", lambda: window.session.reroll(), "Ctrl+R")
    view = window.menuBar().addMenu("&View")
    _act(window, view, "&Whole map", window.view.reset_camera, "Ctrl+0")
    _act(window, view, "Save &picture...", partial(save_picture, window))
    run = window.menuBar().addMenu("&Run")
    _act(window, run, "&Start: write the maps", window.generate, "F5")
    _act(window, run, "&Export for other programs...", partial(show_export, window), "Ctrl+Shift+E")
    _act(window, run, "&Build sheet...", partial(show_sheet, window), "Ctrl+B")
    _act(window, run, "Open the &folder", window.start_form.open_folder)
    window.gazebo.fill(run)
    _act(window, run, "Send to the &running simulation", partial(send, window), "F6")
    _act(window, run, "Show &command line and Python code...", partial(show_spelled, window), "Ctrl+E")
    _act(window, window.menuBar().addMenu("&Help"), "&Manual", partial(show_manual, window), "F1")


def enable_actions(window: Window) -> None:
    """Only what can be done can be chosen."""
    session, row, last = window.session, window.selected, len(window.session.draft.rows) - 1
    writable = session.problem is None and not window.start_form.busy
    possible = {
        "Undo": session.can_undo,
        "Redo": session.can_redo,
        "Duplicate obstacle": row >= 0,
        "Remove obstacle": row >= 0,
        "Move obstacle up": row > 0,
        "Move obstacle down": 0 <= row < last,
        "Start: write the maps": writable,
        "Export for other programs": writable,
        "Build sheet": writable,
        "Open the folder": window.start_form.written is not None,
    }
    for action in window.findChildren(QAction):
        if action.objectName() in possible:
            action.setEnabled(possible[action.objectName()])


def choose_example(window: Window) -> None:
    """Start from a copy of an example that is asked for."""
    dialog = ExampleDialog(window)
    dialog.chosen.connect(lambda path: replace_session(window, partial(Session.copied, path)))
    dialog.open()


def show_spelled(window: Window) -> None:
    """The command and the program that make the same maps."""
    SpelledDialog(window.start_form.job(window.session.recipe), window).open()


def show_export(window: Window) -> None:
    """The maps, or the one that is shown, in other formats."""
    ExportDialog(window.session.recipe, window.index.value(), window).open()


def show_sheet(window: Window) -> None:
    """The build sheet of the map that is shown."""
    SheetDialog(window.session.recipe, window.index.value(), window).open()


def send(window: Window) -> None:
    """The map that is shown, into the simulation that runs."""
    window.sending.send(window.session.recipe, window.index.value())


def save_picture(window: Window) -> None:
    """Write what the view shows to a file that is asked for."""
    name, _ = QFileDialog.getSaveFileName(window, "Save the picture", "field.png", "Pictures (*.png)")
    if name:
        window.view.save_picture(Path(name))


def _act(
    window: Window, menu: QMenu, text: str, run: Callable[[], object], keys: QKeySequence.StandardKey | str = ""
) -> None:
    action = QAction(text, window)
    action.setObjectName(text.replace("&", "").rstrip("."))
    action.setShortcut(QKeySequence(keys))
    action.triggered.connect(lambda: run())
    menu.addAction(action)


def _with_row(window: Window, change: Callable[[Window, int], None]) -> None:
    if window.selected >= 0:
        change(window, window.selected)


def _duplicate(window: Window, row: int) -> None:
    window.selected = row + 1
    window.session.duplicate(row)


def _remove(window: Window, row: int) -> None:
    window.session.remove(row)


def _shift(window: Window, row: int, *, by: int) -> None:
    window.move_obstacle(row, row + by)
