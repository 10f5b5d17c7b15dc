"""Recipes, maps of data sets and heights: how they come into the window, are saved, and are remembered."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QSettings
from PySide6.QtGui import QDropEvent
from PySide6.QtWidgets import QFileDialog, QMenu, QMessageBox

from rsegen.errors import RsegenError
from rsegen.gui.dataset_dialog import DatasetDialog
from rsegen.gui.reading import Reading
from rsegen.gui.session import Session
from rsegen.io.dataset.manifest import MANIFEST
from rsegen.io.dataset.map_reference import dataset_at
from rsegen.io.importers import IMPORTERS

if TYPE_CHECKING:
    from rsegen.gui.window import Window

RECIPE_SUFFIXES = (".yaml", ".yml", ".json")
RECIPES = f"Recipes ({' '.join('*' + suffix for suffix in RECIPE_SUFFIXES)})"
REMEMBERED = 8
"""So many recent files."""


def replace_session(window: Window, make: Callable[[], Session]) -> bool:
    """Another session, unless the present one is not saved and is to be kept, or there is none; whether it came."""
    question = "The recipe is not saved. Leave it?"
    if window.session.unsaved and QMessageBox.question(window, "rsegen", question) != QMessageBox.StandardButton.Yes:
        return False
    try:
        window.take(make())
    except RsegenError as error:
        QMessageBox.warning(window, "rsegen", str(error))
        return False
    return True


def choose_file(window: Window) -> None:
    """Open a recipe, or the manifest of a data set, that is asked for."""
    name, _ = QFileDialog.getOpenFileName(window, "Open a recipe, or manifest.json of a data set", "", RECIPES)
    if name:
        open_file(window, Path(name))


def open_file(window: Window, path: Path) -> None:
    """Open a recipe, or DIR#17 of a data set, and remember that; of a data set alone, ask which map."""
    if folder := dataset_at(path):
        choose_map(window, folder)
    elif replace_session(window, partial(Session.opened, path)):
        _remember(path)


def choose_dataset(window: Window) -> None:
    """Open a map of a data set; both are asked for."""
    name = QFileDialog.getExistingDirectory(window, "Folder of a data set")
    if name:
        choose_map(window, Path(name))


def choose_map(window: Window, folder: Path) -> None:
    """Open a map of a data set, which is asked for."""
    try:
        dialog = DatasetDialog(folder.resolve(), window)
    except RsegenError as error:
        QMessageBox.warning(window, "rsegen", str(error))
        return
    dialog.chosen.connect(partial(open_file, window))
    dialog.open()


def choose_heights(window: Window) -> None:
    """Read heights from a file that is asked for."""
    suffixes = " ".join(f"*{suffix}" for suffix in IMPORTERS)
    name, _ = QFileDialog.getOpenFileName(window, "Read heights", "", f"Tables, arrays, images, maps ({suffixes})")
    if name:
        read_heights(window, Path(name))


def read_heights(window: Window, path: Path) -> None:
    """A new recipe from heights, read as the dialog says."""
    reading = Reading(window, path)
    if reading.exec() and reading.recipe:
        replace_session(window, partial(Session.imported, reading.recipe))


def take_dropped(window: Window, path: Path) -> None:
    """Open a recipe or a data set, or read heights."""
    is_recipe = path.suffix.lower() in RECIPE_SUFFIXES or path.is_dir()
    (open_file if is_recipe else read_heights)(window, path)


def dropped(event: QDropEvent) -> Path | None:
    """The recipe, data set or file of heights that is dragged, if it is one."""
    paths = (Path(url.toLocalFile()) for url in event.mimeData().urls())
    known = {*RECIPE_SUFFIXES, *IMPORTERS}
    return next((path for path in paths if path.suffix.lower() in known or (path / MANIFEST).is_file()), None)


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


def _recent() -> list[str]:
    found = QSettings("rsegen", "rsegen").value("recent")
    return [found] if isinstance(found, str) else [str(name) for name in found] if isinstance(found, list) else []


def _remember(path: Path) -> None:
    names = [str(path.resolve()), *(name for name in _recent() if name != str(path.resolve()))]
    QSettings("rsegen", "rsegen").setValue("recent", names[:REMEMBERED])


def fill_recent(window: Window, menu: QMenu) -> None:
    """The recent files, each of which opens itself."""
    menu.clear()
    for name in _recent():
        menu.addAction(name, partial(open_file, window, Path(name)))
    menu.setEnabled(True)
    if menu.isEmpty():
        menu.addAction("none yet").setEnabled(False)
