"""The forms that run a job, with options, export formats, plans of experiments, progress and outcome."""

from __future__ import annotations

import os.path
from collections.abc import Sequence
from dataclasses import fields
from itertools import islice
from pathlib import Path
from typing import Generic, NamedTuple, TypeVar

from PySide6.QtCore import QSettings, QSignalBlocker, Qt, QUrl, Signal
from PySide6.QtGui import QDesktopServices, QPixmap, QResizeEvent
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QFileDialog,
    QFormLayout,
    QGridLayout,
    QLabel,
    QLineEdit,
    QMessageBox,
    QProgressBar,
    QPushButton,
    QSizePolicy,
    QTabWidget,
    QTextBrowser,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from rsegen.errors import OutputError, ParameterError, RsegenError, UserError, shown
from rsegen.exporters.formats import FORMATS, Format
from rsegen.gui.model.jobs import Job
from rsegen.gui.model.simulation import experiment_plans
from rsegen.gui.widgets.editors import Editor, editor
from rsegen.gui.widgets.layouts import MessageLabel, named, row_of
from rsegen.gui.workers import JobThread
from rsegen.params.registry import summary
from rsegen.params.sorts import parameters
from rsegen.run.store import refuse_not_a_folder

_CHECKED = 10_000
"""At most this many files are checked, to ask before they are replaced."""


def may_replace(parent: QWidget, question: str) -> bool:
    """Return whether the user lets something be replaced; by default not."""
    yes, no = QMessageBox.StandardButton.Yes, QMessageBox.StandardButton.No
    return QMessageBox.question(parent, "rsegen", question, yes | no, no) == yes


class FormTexts(NamedTuple):
    """The texts of a form: the settings key of its folder, the default folder, what is written, and its button."""

    key: str
    default: str
    what: str
    button: str
    tip: str


class RunForm(QWidget):
    """A folder, and a run that writes into it; `changed`: a run has started or ended.

    written: the folder of the last run that has ended; is_complete: whether that was neither cancelled nor failed
    """

    changed = Signal()

    def __init__(self, texts: FormTexts, *beside: QWidget, afterwards: Sequence[QWidget] = ()) -> None:
        """`beside` are widgets right of the button, hidden with it during a run; `afterwards` follow its outcome."""
        super().__init__()
        self.run: JobThread | None = None
        self.written: Path | None = None
        self.is_complete = False
        self._is_running = False
        self._texts, self._beside, self._force = texts, beside, False
        self._afterwards: tuple[QWidget, ...] = tuple(afterwards)
        self._make_widgets()
        self._lay_out()
        self._choose.clicked.connect(self._choose_folder)
        self._line.textEdited.connect(lambda: self.error_label.show_message(""))
        self.cancel.clicked.connect(self._cancel)
        self._open.clicked.connect(self.open_folder)

    @property
    def folder(self) -> Path:
        """The output folder in the field."""
        return Path(os.path.expanduser(self._line.text().strip()))  # pathlib's raises for ~nobody

    @folder.setter
    def folder(self, folder: Path) -> None:
        self._line.setText(str(folder))
        self.error_label.show_message("")

    @property
    def busy(self) -> bool:
        """Return whether files are being written."""
        return self._is_running

    def may_write(self, job: Job) -> bool:
        """Return whether a job may write into the folder: asks before files are replaced, and shows what is wrong."""
        try:
            self._refuse()
            job.refuse()
        except RsegenError as error:
            self.error_label.show_message(str(error))
            return False
        self._force = any(path.exists() for path in islice(job.paths(), _CHECKED))
        return not self._force or may_replace(self, job.question)

    def write(self, job: Job) -> None:
        """Run a job in a thread, and remember its folder."""
        QSettings("rsegen", "rsegen").setValue(self._texts.key, str(job.folder.absolute()))
        self.run = run = JobThread(job, force=self._force)
        self.bar.setRange(0, job.steps if 1 < job.steps < 2**31 else 0)
        self.bar.setValue(0)
        run.progressed.connect(self.bar.setValue)
        run.succeeded.connect(self._show_success)
        run.cancelled.connect(self._show_outcome)
        run.failed.connect(self.error_label.show_message)
        run.finished.connect(self._end)  # after its outcome: a run that has ended has shown it
        self.error_label.show_message("")
        self.is_complete = False
        self._outcome.setText("")
        self._is_running = True
        run.start()
        self._show_state()

    def forget(self) -> None:
        """Show no outcome: what was written is not what is open now."""
        if not self.busy:
            self._outcome.setText("")
            self._show_state()

    def open_folder(self) -> None:
        """Open the folder written last in the desktop's file manager."""
        if self.written:
            QDesktopServices.openUrl(QUrl.fromLocalFile(str(self.written.absolute())))

    def stop(self) -> None:
        """Cancel the run, and wait until it has ended."""
        self._cancel()
        if self.run:
            self.run.wait()

    def _make_widgets(self) -> None:
        texts = self._texts
        last = QSettings("rsegen", "rsegen").value(texts.key)
        tip = f"the folder to write the {texts.what} into; it is created if it does not exist"
        self._line = named(QLineEdit(str(last or texts.default)), "folder", title="output folder", tip=tip)
        self._choose = named(QToolButton(), "choose_folder", title="choose a folder", tip="choose a folder")
        self._choose.setText("...")
        self.error_label = MessageLabel("folder_error")
        self.start = named(QPushButton(texts.button), "start", tip=texts.tip)
        self.cancel = named(QPushButton("Cancel"), "cancel", tip="stop; whatever is complete stays")
        self.bar = named(QProgressBar(), "progress")
        self._outcome = named(QLabel(wordWrap=True, textFormat=Qt.TextFormat.PlainText), "outcome")
        self._outcome.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self._open = named(QPushButton("Open the folder"), "open_folder", tip="show the files that were written")
        for button in (self.cancel, self._open):
            button.setAutoDefault(False)

    def _lay_out(self) -> None:
        label = QLabel("Folder")
        label.setBuddy(self._line)
        self._outcome.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)
        self.column = column = QVBoxLayout(self)
        column.addLayout(row_of(label, self._line, self._choose))
        column.addWidget(self.error_label)
        row = row_of(self.start, *self._beside, self.bar, self.cancel)
        row.setStretch(0, 1)
        column.addLayout(row)
        column.addWidget(self._outcome)
        column.addLayout(row_of(self._open, *self._afterwards))
        self._show_state()

    def _refuse(self) -> None:
        if not self._line.text().strip():
            raise OutputError(f"give a folder to write the {self._texts.what} into, such as {self._texts.default}")
        if "\0" in self._line.text():
            raise OutputError(
                f"{shown(self._line.text())} is not the name of a folder; give one such as {self._texts.default}"
            )
        refuse_not_a_folder(self.folder)

    def _choose_folder(self) -> None:
        title = f"Where to write the {self._texts.what}"
        folder = QFileDialog.getExistingDirectory(self, title, str(self.folder.absolute()))
        if folder:
            self.folder = Path(folder)

    def _cancel(self) -> None:
        if self.run:
            self.run.requestInterruption()

    def _end(self) -> None:
        self._is_running = False
        self._show_state()

    def _show_success(self, text: str) -> None:
        self.is_complete = True
        self._show_outcome(text)

    def _show_outcome(self, text: str) -> None:
        folder = self.run.job.result_folder if self.run else None
        self.written = folder if folder and folder.exists() else None
        self._outcome.setText(text)

    def _show_state(self) -> None:
        """Show either the button or the progress bar, and the outcome of the last run if any."""
        is_written = bool(self._outcome.text()) and not self.busy and self.written is not None
        for widget, is_shown in (
            *((widget, not self.busy) for widget in (self.start, *self._beside)),
            (self.cancel, self.busy),
            (self.bar, self.busy),
            (self._outcome, bool(self._outcome.text())),
            *((each, is_written) for each in (self._open, *self._afterwards)),
        ):
            widget.setVisible(is_shown)
        self.changed.emit()


Owner = TypeVar("Owner")


class OptionsForm(QWidget, Generic[Owner]):
    """An editor for each parameter; `editors` are they by name, `form` is the layout."""

    def __init__(self, owner: type[Owner], initial: Owner | None = None) -> None:
        """The editors have the values of `initial` at first, by default the defaults."""
        super().__init__()
        self._owner, self._initial = owner, initial
        self.form = QFormLayout(self)
        self.form.setContentsMargins(0, 0, 0, 0)
        self.editors = {name: self._field(name) for name in parameters(owner)}

    def value(self) -> Owner:
        """An instance with the values in the form; a ParameterError if one is invalid."""
        return self._owner(**{name: each.value() for name, each in self.editors.items()})

    def add(self, each: Editor, title: str) -> None:
        """Add a row."""
        label = QLabel(title)
        label.setToolTip(each.fields[0].toolTip())
        label.setBuddy(each)
        self.form.addRow(label, each)

    def _field(self, name: str) -> Editor:
        each = editor(self._owner, name)
        default = next(field.default for field in fields(self._owner) if field.name == name)  # type: ignore[arg-type]  # a dataclass
        each.show_value(getattr(self._initial, name, default))
        plain = name.removesuffix("_cm").removesuffix("_mm")
        self.add(each, plain.replace("_", " ").capitalize())
        return each


class FormatList(QWidget):
    """A box, a summary and options per format, or what must be installed for it; `changed`: a box was toggled."""

    changed = Signal()

    def __init__(self) -> None:
        super().__init__()
        self._grid = QGridLayout(self)
        self._grid.setColumnStretch(1, 1)
        self._grid.setHorizontalSpacing(16)
        self._boxes: dict[str, QCheckBox] = {}
        self._options: dict[str, OptionsForm[Format]] = {}
        for name, cls in FORMATS.items():
            self._add(name, cls)
        self._grid.setRowStretch(self._grid.rowCount(), 1)

    def any_ticked(self) -> bool:
        """Return whether any format is ticked."""
        return any(box.isChecked() for box in self._boxes.values())

    def formats(self) -> tuple[Format, ...]:
        """The formats that are ticked, with their options; a ParameterError if an option is invalid."""
        return tuple(self._format(name) for name, box in self._boxes.items() if box.isChecked())

    def _format(self, name: str) -> Format:
        try:
            return self._options[name].value() if name in self._options else FORMATS[name]()
        except ParameterError as error:
            raise error.inside(name) from None

    def _add(self, name: str, cls: type[Format]) -> None:
        row, reason = self._grid.rowCount(), _missing(cls)
        self._boxes[name] = box = named(QCheckBox(name), f"format_{name}", title=name, tip=summary(cls))
        about = QLabel(summary(cls), wordWrap=True)
        about.setContentsMargins(0, 3, 0, 3)  # in line with the box
        for column, widget in enumerate((box, about)):
            widget.setEnabled(not reason)
            self._grid.addWidget(widget, row, column, Qt.AlignmentFlag.AlignTop)
        box.toggled.connect(self.changed)
        if reason:
            self._grid.addWidget(_missing_label(name, reason), row + 1, 1)
        elif parameters(cls):
            self._add_options(row + 1, name, cls)

    def _add_options(self, row: int, name: str, cls: type[Format]) -> None:
        """Add the options of a format, visible while its box is ticked."""
        self._options[name] = options = named(OptionsForm(cls), f"options_{name}", title=f"options of {name}")
        options.form.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.FieldsStayAtSizeHint)
        options.form.setContentsMargins(0, 0, 0, 8)
        options.setVisible(False)
        self._boxes[name].toggled.connect(options.setVisible)
        self._grid.addWidget(options, row, 1)


def _missing(cls: type[Format]) -> str:
    """What must be installed for a format, with the command; empty if nothing is missing."""
    try:
        cls().refuse_missing()
    except UserError as error:
        return str(error)
    return ""


def _missing_label(name: str, reason: str) -> MessageLabel:
    """A warning with the reason, whose text can be selected and copied."""
    label = MessageLabel(f"missing_{name}", "warning")
    label.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
    label.show_message(reason)
    return label


_FIRST = "quick"
"""The plan that is chosen at first: the shortest."""


class PlanBox(QWidget):
    """Chooses a plan; `changed` is emitted when it is another one."""

    changed = Signal()

    def __init__(self) -> None:
        super().__init__()
        self._texts = experiment_plans()
        self.box = named(QComboBox(), "plan", tip="an included plan, or a YAML file like these")
        self.box.setMinimumContentsLength(24)
        self.box.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        self.box.addItems(list(self._texts))
        self.box.setCurrentText(_FIRST)
        self.box.currentIndexChanged.connect(self._show)
        choose = named(
            QToolButton(), "choose_plan", title="choose a file", tip="choose a plan of your own, a YAML file"
        )
        choose.setText("...")
        choose.clicked.connect(self._choose_file)
        self._about = named(QLabel(wordWrap=True, textFormat=Qt.TextFormat.PlainText), "about_plan")
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        row = row_of(self.box, choose)
        row.setStretch(0, 1)
        column.addLayout(row)
        column.addWidget(self._about)
        self._about.setText(self._texts[_FIRST])

    def plan(self) -> str:
        """The name of the plan, or the path of its file."""
        return self.box.currentText()

    def show_file(self, path: str) -> None:
        """Choose a file, which is then in the list."""
        with QSignalBlocker(self.box):
            if self.box.findText(path) < 0:
                self.box.addItem(path)
            self.box.setCurrentText(path)
        self._show()

    def _choose_file(self) -> None:
        path, _ = QFileDialog.getOpenFileName(self, "Choose a plan", "", "Plans (*.yaml *.yml);;All files (*)")
        if path:
            self.show_file(path)

    def _show(self) -> None:
        self._about.setText(self._texts.get(self.plan(), "A plan of your own."))
        self.changed.emit()


class ExperimentReport(QTabWidget):
    """Shows the files of an experiment."""

    def __init__(self) -> None:
        super().__init__()
        named(self, "report", title="results of the experiment")
        self.table = named(QTextBrowser(), "table")
        self.plot = named(_Plot(), "plot")
        self.addTab(self.table, "Table")
        self.addTab(self.plot, "Plot")

    def show_files(self, table: Path, plot: Path) -> None:
        """Show a table in Markdown and a picture."""
        self.table.setMarkdown(table.read_text("utf-8"))
        self.plot.show_picture(QPixmap(str(plot)))


class _Plot(QLabel):
    """A picture as wide as its place."""

    def __init__(self) -> None:
        super().__init__(alignment=Qt.AlignmentFlag.AlignCenter)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Ignored)
        self._picture = QPixmap()

    def show_picture(self, picture: QPixmap) -> None:
        """Show a picture."""
        self._picture = picture
        self._fit()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Fit the picture to the new size."""
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        if not self._picture.isNull():
            ratio = self.devicePixelRatioF()
            size = (self.size() * ratio).boundedTo(self._picture.size())
            fitted = self._picture.scaled(
                size, Qt.AspectRatioMode.KeepAspectRatio, Qt.TransformationMode.SmoothTransformation
            )
            fitted.setDevicePixelRatio(ratio)
            self.setPixmap(fitted)
