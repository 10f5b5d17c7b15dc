"""The menus of the window, and what they start."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QSettings
from PySide6.QtGui import QAction, QKeySequence
from PySide6.QtWidgets import QFileDialog, QMenu, QMessageBox

from rsegen.errors import RsegenError
from rsegen.gui.example_dialog import ExampleDialog
from rsegen.gui.manual import show_manual
from rsegen.gui.reading import Reading
from rsegen.gui.session import Session
from rsegen.gui.spelled_dialog import SpelledDialog
from rsegen.importers import FORMATS

if TYPE_CHECKING:
    from rsegen.gui.window import Window

RECIPE_SUFFIXES = (".yaml", ".yml", ".json")
RECIPES = f"Recipes ({' '.join('*' + suffix for suffix in RECIPE_SUFFIXES)})"
REMEMBERED = 8
"""So many recent files."""


def add_menus(window: Window) -> None:
    """File, Edit, View, Run and Help."""
    files = window.menuBar().addMenu("&File")
    _act(window, files, "&New", lambda: replace_session(window, Session.new), QKeySequence.StandardKey.New)
    _act(window, files, "New from &example...", partial(choose_example, window), "Ctrl+Shift+N")
    _act(window, files, "&Open...", partial(choose_file, window), QKeySequence.StandardKey.Open)
    recent = files.addMenu("Open &recent")
    recent.aboutToShow.connect(partial(_fill_recent, window, recent))
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
    _act(window, run, "Open the &folder", window.start_form.open_folder)
    window.gazebo.fill(run)
    _act(window, run, "Send to the &running simulation", partial(send, window), "F6")
    _act(window, run, "Show &command line and Python code...", partial(show_spelled, window), "Ctrl+E")
    _act(window, window.menuBar().addMenu("&Help"), "&Manual", partial(show_manual, window), "F1")


def enable_actions(window: Window) -> None:
    """Only what can be done can be chosen."""
    session, row, last = window.session, window.selected, len(window.session.draft.rows) - 1
    possible = {
        "Undo": session.can_undo,
        "Redo": session.can_redo,
        "Duplicate obstacle": row >= 0,
        "Remove obstacle": row >= 0,
        "Move obstacle up": row > 0,
        "Move obstacle down": 0 <= row < last,
        "Start: write the maps": window.start.isEnabled() and not window.start_form.busy,
        "Open the folder": window.start_form.written is not None,
    }
    for action in window.findChildren(QAction):
        if action.objectName() in possible:
            action.setEnabled(possible[action.objectName()])


def replace_session(window: Window, make: Callable[[], Session]) -> None:
    """Another session, unless the present one is not saved and is to be kept."""
    question = "The recipe is not saved. Leave it?"
    if window.session.unsaved and QMessageBox.question(window, "rsegen", question) != QMessageBox.StandardButton.Yes:
        return
    try:
        window.take(make())
    except RsegenError as error:
        QMessageBox.warning(window, "rsegen", str(error))


def choose_example(window: Window) -> None:
    """Start from a copy of an example that is asked for."""
    dialog = ExampleDialog(window)
    dialog.chosen.connect(lambda path: replace_session(window, partial(Session.copied, path)))
    dialog.open()


def show_spelled(window: Window) -> None:
    """The command and the program that make the same maps."""
    SpelledDialog(window.session.recipe, str(window.start_form.folder), window).open()


def send(window: Window) -> None:
    """The map that is shown, into the simulation that runs."""
    window.sending.send(window.session.recipe, window.index.value())


def choose_file(window: Window) -> None:
    """Open a recipe that is asked for."""
    name, _ = QFileDialog.getOpenFileName(window, "Open a recipe", "", RECIPES)
    if name:
        open_file(window, Path(name))


def open_file(window: Window, path: Path) -> None:
    """Open a recipe, and remember that."""
    replace_session(window, partial(Session.opened, path))
    if window.session.path == path:
        _remember(path)


def choose_heights(window: Window) -> None:
    """Read heights from a file that is asked for."""
    suffixes = " ".join(f"*{suffix}" for suffix in FORMATS)
    name, _ = QFileDialog.getOpenFileName(window, "Read heights", "", f"Tables, arrays, images, maps ({suffixes})")
    if name:
        read_heights(window, Path(name))


def read_heights(window: Window, path: Path) -> None:
    """A new recipe from heights, read as the dialog says."""
    reading = Reading(window, path)
    if reading.exec() and reading.recipe:
        replace_session(window, partial(Session.imported, reading.recipe))


def take_dropped(window: Window, path: Path) -> None:
    """Open a recipe, or read heights."""
    (open_file if path.suffix.lower() in RECIPE_SUFFIXES else read_heights)(window, path)


def save(window: Window) -> None:
    """Write the recipe to its file."""
    if window.session.path is None:
        save_as(window)
        return
    try:
        window.session.save(window.session.path)
        _remember(window.session.path)
    except RsegenError as error:
        QMessageBox.warning(window, "rsegen", str(error))


def save_as(window: Window) -> None:
    """Write the recipe to a file that is asked for."""
    name, _ = QFileDialog.getSaveFileName(window, "Save the recipe", f"{window.session.recipe.name}.yaml", RECIPES)
    if name:
        window.session.path = Path(name)
        save(window)


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


def _recent() -> list[str]:
    found = QSettings("rsegen", "rsegen").value("recent")
    return [found] if isinstance(found, str) else [str(name) for name in found] if isinstance(found, list) else []


def _remember(path: Path) -> None:
    names = [str(path.resolve()), *(name for name in _recent() if name != str(path.resolve()))]
    QSettings("rsegen", "rsegen").setValue("recent", names[:REMEMBERED])


def _fill_recent(window: Window, menu: QMenu) -> None:
    menu.clear()
    for name in _recent():
        menu.addAction(name, partial(open_file, window, Path(name)))
    menu.setEnabled(True)
    if menu.isEmpty():
        menu.addAction("none yet").setEnabled(False)
