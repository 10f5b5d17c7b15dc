"""The dialogs that run a job: options, an output folder and progress; of a drive and of an experiment."""

from __future__ import annotations

from PySide6.QtCore import QPoint, QSize, Qt, QTimer
from PySide6.QtGui import QPixmap
from PySide6.QtWidgets import QDialog, QDialogButtonBox, QLabel, QVBoxLayout, QWidget

from rsegen.errors import RsegenError
from rsegen.gui.model.jobs import PICTURE, PLOT, TABLE, DriveJob, DriveSettings, ExperimentJob, ExperimentSettings, Job
from rsegen.gui.widgets.layouts import named
from rsegen.gui.widgets.run_form import ExperimentReport, FormTexts, OptionsForm, PlanBox, RunForm
from rsegen.recipe.recipe import Recipe


class JobDialog(QDialog):
    """The base of dialogs that run a job; their options cannot be changed during a run, and closing cancels it."""

    def __init__(self, name: str, title: str, texts: FormTexts, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        named(self, name)
        self.setWindowTitle(title)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._soon = QTimer(self, singleShot=True, interval=0)
        self._soon.timeout.connect(lambda: self.make_room())
        self.form = RunForm(texts)
        self.form.start.setDefault(True)
        self.form.start.clicked.connect(self._write)
        self.form.changed.connect(self.show_state)
        self.form.column.setContentsMargins(0, 0, 0, 0)

    def job(self) -> Job:
        """The job by the options in the dialog; an RsegenError if one is invalid."""
        raise NotImplementedError

    def lay_out(self, body: QWidget, stretch: int = 0, results: QWidget | None = None) -> None:
        """Lay out the options, the form, the results if there is a widget for them, and Close."""
        self._body = body
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        buttons.button(QDialogButtonBox.StandardButton.Close).setAutoDefault(False)
        buttons.rejected.connect(self.reject)
        column = QVBoxLayout(self)
        column.setSpacing(12)
        column.addWidget(body, stretch)
        column.addWidget(self.form)
        if results:
            column.addWidget(results, 1)
        column.addWidget(buttons)

    def show_state(self) -> None:
        """Enable the options unless a job is running."""
        self._body.setEnabled(not self.form.busy)
        self._soon.start()

    def make_room(self, least: QSize = QSize()) -> None:  # noqa: B008  # an empty one is never changed
        """Grow to what is shown now, and at least to a size; within the screen."""
        screen, place = self.screen().availableGeometry(), self.geometry()
        title = place.top() - self.frameGeometry().top()
        width = max(place.width(), least.width())
        needed = self.heightForWidth(width) if self.hasHeightForWidth() else self.sizeHint().height()
        size = QSize(width, max(place.height(), needed, least.height()))
        place.setSize(size.boundedTo(QSize(screen.width(), screen.height() - title)))
        place.moveBottomRight(QPoint(min(place.right(), screen.right()), min(place.bottom(), screen.bottom())))
        self.setGeometry(place)

    def done(self, result: int) -> None:
        """Cancel the run, and close."""
        self.form.stop()
        super().done(result)

    def _write(self) -> None:
        try:
            job = self.job()
        except RsegenError as error:
            self.form.error_label.show_message(str(error))
            return
        if self.form.may_write(job):
            self.form.write(job)


_DRIVE_TEXTS = FormTexts(
    "drive_folder", "drives", "drive", "Drive", "drive, and write trajectories, metrics and a picture"
)
_WIDTH = 340
"""The width of the picture in pixels."""


class DriveDialog(JobDialog):
    """Asks which robots drive and how; then shows how far they got, and their trajectories."""

    def __init__(self, recipe: Recipe, index: int, parent: QWidget | None = None, *, robot: str = "") -> None:
        """robot: the one that is chosen at first, by default the usual one."""
        super().__init__("drive_dialog", f"Drive over {recipe.map_name(index)}", _DRIVE_TEXTS, parent)
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


_EXPERIMENT_TEXTS = FormTexts(
    "experiment_folder", "experiments", "results", "Run", "run the trials, and write tables, a plot and trajectories"
)
_ABOUT = (
    "What maps cost the simulator: robots drive randomly over maps of several sizes, which the plan has, in a Gazebo "
    "server without a window, as by rsegen experiment. The same plan in the same folder continues a cancelled one."
)
_SIZE, _RESULTS_HEIGHT = QSize(980, 780), 240
"""With results, in pixels; no larger than the screen."""


class ExperimentDialog(JobDialog):
    """Asks for a plan and a simulator; then shows the results in `report`."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("experiment_dialog", "Experiment", _EXPERIMENT_TEXTS, parent)
        self.setMinimumWidth(620)
        self.plan, self._settings = PlanBox(), OptionsForm(ExperimentSettings)
        self._settings.form.insertRow(0, "Plan", self.plan)
        self._trials = named(QLabel(wordWrap=True), "trials")
        self._settings.form.addRow("", self._trials)
        self.report = ExperimentReport()
        self.report.setMinimumHeight(_RESULTS_HEIGHT)
        self.report.hide()
        for changed in (self.plan.changed, *(each.edited for each in self._settings.editors.values())):
            changed.connect(self._count)
        self.form.bar.setFormat("%v of %m trials")
        self.form.start.clicked.connect(self._continue_next_time)
        self.lay_out(self._options(), results=self.report)
        self._count()

    def job(self) -> ExperimentJob:
        """The experiment by the settings in the dialog; a UserError if its plan is wrong."""
        return ExperimentJob.of(self.form.folder, self.plan.plan(), self._settings.value())

    def show_state(self) -> None:
        """Show the results once all trials have ended."""
        super().show_state()
        job = self.form.run.job if self.form.run else None
        if not isinstance(job, ExperimentJob):
            return
        files = [job.result_folder / name for name in (TABLE, PLOT)]
        is_complete = not self.form.busy and self.form.is_complete and all(file.exists() for file in files)
        if is_complete:
            self.report.show_files(*files)
            self.make_room(_SIZE)
        self.report.setVisible(is_complete)

    def _options(self) -> QWidget:
        body = QWidget()
        column = QVBoxLayout(body)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(QLabel(_ABOUT, wordWrap=True))
        column.addWidget(self._settings)
        return body

    def _count(self) -> None:
        """Say how many trials the plan has, or what is wrong with it."""
        self.form.error_label.show_message("")
        try:
            summary = self.job().summary
        except RsegenError as error:
            self._trials.setText("")
            self.form.error_label.show_message(str(error))
            return
        seconds = summary.trials * summary.seconds
        at_least = f"{seconds:.0f} s" if seconds < 120 else f"{seconds / 60:.0f} minutes"
        trials = f"{summary.trials} trial{'s'[: summary.trials != 1]} of {summary.seconds:g} s each"
        self._trials.setText(f"{trials}: {at_least}, and the time to load their worlds")

    def _continue_next_time(self) -> None:
        """Delete earlier results once only: the next run continues."""
        if self.form.busy:
            self._settings.editors["start_again"].show_value(False)  # noqa: FBT003  # a value of a recipe file
