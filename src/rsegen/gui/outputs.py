"""The outputs of the open recipe: worlds, exports, build sheets, code, and a map in the running simulation."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtWidgets import QMessageBox, QWidget

from rsegen.errors import RsegenError
from rsegen.gui.dialogs.job import DriveDialog, ExperimentDialog
from rsegen.gui.dialogs.opening import ask_where_to_save
from rsegen.gui.dialogs.outputs import CodeDialog, ExportDialog, PictureSizeDialog, SavingDialog, SheetDialog
from rsegen.gui.model.document import Document
from rsegen.gui.widgets.field_view import FieldView
from rsegen.gui.widgets.layouts import PassingNote
from rsegen.gui.widgets.map_views import MapStatusBar
from rsegen.gui.widgets.plan_view import PlanView
from rsegen.gui.widgets.recipe_forms import StartForm
from rsegen.gui.workers import PictureSaver, SpawnJob


class Outputs:
    """Writes the open recipe, and opens the dialogs that do, for the map and the robot of the status bar."""

    def __init__(
        self, document: Document, start_form: StartForm, status: MapStatusBar, note: PassingNote, parent: QWidget
    ) -> None:
        self._document, self._form, self._status, self._note, self._parent = document, start_form, status, note, parent
        self._index = status.shown_index
        self.spawn_job, self.pictures = SpawnJob(parent), PictureSaver(parent)
        self.spawn_job.message.connect(note.show_message)
        self.pictures.saved.connect(self._tell_saved)

    @property
    def is_valid(self) -> bool:
        """Return whether the recipe is valid; else the last valid one is not what the window shows."""
        return self._document.session.problem is None

    @property
    def is_possible(self) -> bool:
        """Return whether the recipe is valid and nothing is being written."""
        return self.is_valid and not self._form.busy

    def start(self) -> None:
        """Write the maps into the folder of the form; first draw another seed, unless it is kept."""
        session = self._document.session
        if self.is_possible and self._form.may_write(self._form.job(session.recipe)):
            if not session.seed_kept:
                session.reroll()
            self._form.write(self._form.job(session.recipe))

    def start_into(self, folder: Path) -> None:
        """Write the maps into another folder."""
        self._form.folder = folder
        self.start()

    def export(self) -> None:
        """Open the dialog that exports the maps, or the one that is shown, if the recipe is valid."""
        if self.is_possible:
            ExportDialog(self._document.session.recipe, self._index(), self._parent).open()

    def build_sheet(self) -> None:
        """Open the dialog that writes the build sheet of the map that is shown."""
        SheetDialog(self._document.session.recipe, self._index(), self._parent).open()

    def drive(self) -> None:
        """Open the dialog that drives robots over the map that is shown."""
        DriveDialog(self._document.session.recipe, self._index(), self._parent, robot=self._status.robot_name).open()

    def experiment(self) -> None:
        """Open the dialog that runs the trials of an experiment, on maps of its own."""
        ExperimentDialog(self._parent).open()

    def show_code(self) -> None:
        """Open the dialog with the command line and the Python code that write the same maps."""
        CodeDialog(self._form.job(self._document.session.recipe), self._parent).open()

    def spawn(self) -> None:
        """Spawn the map that is shown in the running simulation."""
        self.spawn_job.spawn(self._document.session.recipe, self._index())

    def save_picture(self, view: FieldView) -> None:
        """Ask for a size and a file, and save a picture of the view."""
        dialog = PictureSizeDialog(view.pixels, self._parent)
        dialog.accepted.connect(
            lambda: self._save(
                "Save the picture",
                "field.png",
                "PNG (*.png);;JPEG (*.jpg *.jpeg)",
                lambda path: SavingDialog(self.pictures, view.drawing(dialog.size_in_pixels), path, self._parent),
            )
        )
        dialog.open()

    def save_plan(self, plan: PlanView) -> None:
        """Ask for a file, and save the plan."""

        def save(path: Path) -> None:
            plan.save(path)
            self._tell_saved(path)

        self._save("Save the plan", "plan.svg", "SVG (*.svg);;PDF (*.pdf);;PNG (*.png)", save)

    def _tell_saved(self, path: Path) -> None:
        self._note.show_message(f"Saved {path.absolute()}")

    def _save(self, title: str, default: str, formats: str, save: Callable[[Path], object]) -> None:
        """Ask for a file, and save something in it."""
        path = ask_where_to_save(self._parent, title, default, formats)
        try:
            if path:
                save(path)
        except RsegenError as error:
            QMessageBox.warning(self._parent, "rsegen", str(error))

    def stop(self) -> None:
        """Cancel what is being written, and wait until it has ended."""
        self._form.stop()
        self.spawn_job.stop()
        self.pictures.stop()
