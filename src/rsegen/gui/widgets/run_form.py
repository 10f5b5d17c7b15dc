"""A form that runs a job: the output folder, a start button, a progress bar, and the outcome."""

from __future__ import annotations

import os.path
from collections.abc import Sequence
from itertools import islice
from pathlib import Path
from typing import NamedTuple

from PySide6.QtCore import QSettings, Qt, QUrl, Signal
from PySide6.QtGui import QDesktopServices
from PySide6.QtWidgets import (
    QFileDialog,
    QLabel,
    QLineEdit,
    QMessageBox,
    QProgressBar,
    QPushButton,
    QSizePolicy,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from rsegen.errors import OutputError, RsegenError, shown
from rsegen.gui.model.jobs import Job
from rsegen.gui.widgets.layouts import row_of
from rsegen.gui.widgets.message_label import MessageLabel
from rsegen.gui.widgets.named import named
from rsegen.gui.workers.job_thread import JobThread
from rsegen.run.store import refuse_not_a_folder

_CHECKED = 10_000
"""At most this many files are checked, to ask before they are replaced."""


def may_replace(parent: QWidget, question: str) -> bool:
    """Whether the user lets something be replaced; by default not."""
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
        """Whether files are being written."""
        return self._is_running

    def may_write(self, job: Job) -> bool:
        """Whether a job may write into the folder: asks before files are replaced, and shows what is wrong."""
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
