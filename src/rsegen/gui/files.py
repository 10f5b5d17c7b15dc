"""Opening and saving: recipes, maps of data sets and heights."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

from PySide6.QtGui import QDropEvent
from PySide6.QtWidgets import QFileDialog, QMessageBox, QWidget

from rsegen.errors import RsegenError
from rsegen.gui.dialogs.gallery import DatasetDialog
from rsegen.gui.dialogs.opening import ExampleDialog, HeightsDialog, ask_where_to_save
from rsegen.gui.model.document import Document
from rsegen.gui.model.session import Session
from rsegen.gui.widgets.simulator_actions import RecentFiles
from rsegen.io.dataset.layout import MANIFEST
from rsegen.io.importers import IMPORTERS
from rsegen.io.targets import dataset_at

RECIPE_SUFFIXES = (".yaml", ".yml", ".json")
RECIPES = f"Recipes ({' '.join('*' + suffix for suffix in RECIPE_SUFFIXES)})"


class Files:
    """Opens files into a document and saves it; dialogs have `parent`, errors are shown in a message box."""

    def __init__(self, document: Document, parent: QWidget) -> None:
        self._document, self._parent = document, parent
        self.recent = RecentFiles(parent)
        self.recent.chosen.connect(self.open)

    def new(self) -> None:
        """Open a new recipe."""
        self._replace(Session.new)

    def may_leave(self) -> bool:
        """Return whether the open recipe may be left: it is saved, the user saves it now, or does not want to."""
        session, standard = self._document.session, QMessageBox.StandardButton
        if not session.unsaved:
            return True
        question, buttons = f"Save the changes of {session.title}?", standard.Save | standard.Discard | standard.Cancel
        answer = QMessageBox.question(self._parent, "rsegen", question, buttons, standard.Save)
        if answer == standard.Save:
            self.save()
        return answer == standard.Discard or not session.unsaved

    def choose_example(self) -> None:
        """Ask for an example, and open a copy of it."""
        dialog = ExampleDialog(self._parent)
        dialog.chosen.connect(self.open_example)
        dialog.open()

    def open_example(self, path: Path) -> None:
        """Open a copy of an example."""
        self._replace(partial(Session.copied, path))

    def choose_file(self) -> None:
        """Ask for a recipe, or for the manifest of a data set, and open it."""
        title = "Open a recipe, or manifest.json of a data set"
        name, _ = QFileDialog.getOpenFileName(self._parent, title, "", f"{RECIPES};;All files (*)")
        if name:
            self.open(Path(name))

    def open(self, path: Path) -> None:
        """Open and remember a recipe or DIR#17 of a data set; of a data set alone, ask for the map first."""
        if folder := dataset_at(path):
            self.choose_map(folder)
        elif self._replace(partial(Session.opened, path)):
            self.recent.remember(path)

    def choose_dataset(self) -> None:
        """Ask for a data set and one of its maps, and open that."""
        name = QFileDialog.getExistingDirectory(self._parent, "Folder of a data set")
        if name:
            self.choose_map(Path(name))

    def choose_map(self, folder: Path) -> None:
        """Ask for a map of a data set, and open it."""
        try:
            dialog = DatasetDialog(folder.resolve(), self._parent)
        except RsegenError as error:
            self._show_error(error)
            return
        dialog.chosen.connect(self.open)
        dialog.open()

    def choose_heights(self) -> None:
        """Ask for a file of heights, and read it."""
        suffixes = " ".join(f"*{suffix}" for suffix in IMPORTERS)
        filter_ = f"Tables, arrays, images, maps ({suffixes})"
        name, _ = QFileDialog.getOpenFileName(self._parent, "Read heights", "", filter_)
        if name:
            self.read_heights(Path(name))

    def read_heights(self, path: Path) -> None:
        """Open a new recipe with the heights of a file, read by the options that a dialog asks for."""
        try:
            dialog = HeightsDialog(self._parent, path)
        except RsegenError as error:
            self._show_error(error)
            return
        if dialog.exec() and dialog.recipe:
            self._replace(partial(Session.imported, dialog.recipe))

    def open_dropped(self, path: Path) -> None:
        """Open a recipe or a data set, or read heights."""
        is_recipe = path.suffix.lower() in RECIPE_SUFFIXES or path.is_dir()
        (self.open if is_recipe else self.read_heights)(path)

    def save(self) -> None:
        """Save the recipe to its file; ask for one if it has none."""
        path = self._document.session.path
        if path is None:
            self.save_as()
        else:
            self._save(path)

    def save_as(self) -> None:
        """Ask for a file, and save the recipe to it."""
        session = self._document.session
        if path := ask_where_to_save(self._parent, "Save the recipe", f"{session.recipe.name}.yaml", RECIPES):
            self._save(path)

    def _save(self, path: Path) -> None:
        """Save the recipe to a file, which is from then on its file; show why if it cannot be."""
        session = self._document.session
        if session.problem is None and session.switched_off and not self._may_drop(session.switched_off):
            return
        try:
            session.save(path)
            self.recent.remember(path)
        except RsegenError as error:
            self._show_error(error)

    def _may_drop(self, number: int) -> bool:
        """Ask whether to save without the obstacles that are switched off."""
        standard = QMessageBox.StandardButton
        are, them = ("obstacle is", "it") if number == 1 else ("obstacles are", "them")
        question = f"{number} {are} switched off and a recipe file can't hold {them}: save without {them}?"
        buttons = standard.Save | standard.Cancel
        box = QMessageBox(QMessageBox.Icon.Question, "rsegen", question, buttons, self._parent)
        box.setDefaultButton(standard.Cancel)
        box.button(standard.Save).setText(f"Save without {them}")
        return box.exec() == standard.Save

    def _replace(self, make: Callable[[], Session]) -> bool:
        """Open another session if the present one may be left; gives whether it was opened."""
        if not self.may_leave():
            return False
        try:
            self._document.open(make())
        except RsegenError as error:
            self._show_error(error)
            return False
        return True

    def _show_error(self, error: RsegenError) -> None:
        QMessageBox.warning(self._parent, "rsegen", str(error))


def dropped_path(event: QDropEvent) -> Path | None:
    """The path that is dragged if it is a recipe, a data set or a file of heights."""
    paths = (Path(url.toLocalFile()) for url in event.mimeData().urls())
    known = {*RECIPE_SUFFIXES, *IMPORTERS}
    return next((path for path in paths if path.suffix.lower() in known or (path / MANIFEST).is_file()), None)
