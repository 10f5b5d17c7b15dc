"""The dialog that drives robots over the map that is shown, in Gazebo without a window."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QPixmap
from PySide6.QtWidgets import QLabel, QVBoxLayout, QWidget

from rsegen.gui.dialogs.job import JobDialog
from rsegen.gui.model.drive_job import PICTURE, DriveJob, DriveSettings
from rsegen.gui.widgets.named import named
from rsegen.gui.widgets.options_form import OptionsForm
from rsegen.gui.widgets.run_form import FormTexts
from rsegen.recipe.recipe import Recipe

_TEXTS = FormTexts("drive_folder", "drives", "drive", "Drive", "drive, and write trajectories, metrics and a picture")
_WIDTH = 340
"""The width of the picture in pixels."""


class DriveDialog(JobDialog):
    """Asks which robots drive and how; then shows how far they got, and their trajectories."""

    def __init__(self, recipe: Recipe, index: int, parent: QWidget | None = None, *, robot: str = "") -> None:
        """robot: the one that is chosen at first, by default the usual one."""
        super().__init__("drive_dialog", f"Drive over {recipe.map_name(index)}", _TEXTS, parent)
        self.setMinimumWidth(540)
        self._recipe = recipe.alone(index)
        self._settings = OptionsForm(DriveSettings, DriveSettings(robot=robot) if robot else None)
        self._picture = named(QLabel(alignment=Qt.AlignmentFlag.AlignCenter), "trajectories")
        self._picture.hide()
        about = "Robots drive in a Gazebo server without a window, the newest that is installed, as by rsegen drive."
        body = QWidget()
        column = QVBoxLayout(body)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(QLabel(about, wordWrap=True))
        column.addWidget(self._settings)
        column.addWidget(self._picture)
        self.lay_out(body)

    def job(self) -> DriveJob:
        """The drive by the settings in the dialog."""
        return DriveJob(recipe=self._recipe, folder=self.form.folder, settings=self._settings.value())

    def show_state(self) -> None:
        """Show the picture of the drive once it has ended."""
        super().show_state()
        job = self.form.run.job if self.form.run else None
        if isinstance(job, DriveJob) and not self.form.busy and self.form.written:
            picture = QPixmap(str(job.result_folder / PICTURE))
            self._picture.setPixmap(picture.scaledToWidth(_WIDTH, Qt.TransformationMode.SmoothTransformation))
            self._picture.setVisible(not picture.isNull())
