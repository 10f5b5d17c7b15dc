"""The dialog that runs an experiment in Gazebo without a window, and shows its table and plot."""

from __future__ import annotations

from PySide6.QtCore import QSize
from PySide6.QtWidgets import QLabel, QVBoxLayout, QWidget

from rsegen.errors import RsegenError
from rsegen.gui.dialogs.job import JobDialog
from rsegen.gui.model.experiment_job import PLOT, TABLE, ExperimentJob, ExperimentSettings
from rsegen.gui.widgets.experiment_report import ExperimentReport
from rsegen.gui.widgets.named import named
from rsegen.gui.widgets.options_form import OptionsForm
from rsegen.gui.widgets.plan_box import PlanBox
from rsegen.gui.widgets.run_form import FormTexts

_TEXTS = FormTexts(
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
        super().__init__("experiment_dialog", "Experiment", _TEXTS, parent)
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
