"""A folder to write into, the run that does it, how far it is, and what came of it."""

from __future__ import annotations

from itertools import islice
from pathlib import Path
from typing import NamedTuple

from PySide6.QtCore import QSettings, QUrl, Signal
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

from rsegen.errors import OutputError, RsegenError
from rsegen.gui.editors import named
from rsegen.gui.jobs import Job
from rsegen.gui.layout import row_of
from rsegen.gui.notice import Notice
from rsegen.gui.running import Run
from rsegen.io.writer import refuse_not_a_folder

_LOOKED_FOR = 10_000
"""So many files are looked for, to ask before they are replaced."""


class Words(NamedTuple):
    """What a form is about: the key by which its folder is remembered, that folder at first, and its button."""

    key: str
    usual: str
    what: str
    button: str
    tip: str


class RunForm(QWidget):
    """A folder, and a run that writes into it; `changed` tells that one has begun or ended."""

    changed = Signal()

    def __init__(self, words: Words, *beside: QWidget) -> None:
        """`beside` stands right of the button, and is gone with it during a run."""
        super().__init__()
        self.run: Run | None = None
        self.written: Path | None = None
        self._words, self._beside, self._force = words, beside, False
        self._make_widgets()
        self._lay_out()
        self._choose.clicked.connect(self._ask)
        self._line.textEdited.connect(lambda: self.complaint.say(""))
        self.cancel.clicked.connect(self._stop)
        self._open.clicked.connect(self.open_folder)

    @property
    def folder(self) -> Path:
        """Where the files go, as it stands in the line."""
        return Path(self._line.text().strip()).expanduser()

    @folder.setter
    def folder(self, folder: Path) -> None:
        self._line.setText(str(folder))
        self.complaint.say("")

    @property
    def busy(self) -> bool:
        """Whether files are being written."""
        return self.run is not None and self.run.isRunning()

    def is_free_for(self, job: Job) -> bool:
        """Whether a job may write there: asks where its files are there already, says what is wrong."""
        try:
            self._refuse()
            job.refuse()
        except RsegenError as error:
            self.complaint.say(str(error))
            return False
        self._force = any(path.exists() for path in islice(job.paths(), _LOOKED_FOR))
        return not self._force or QMessageBox.question(self, "rsegen", job.question) == QMessageBox.StandardButton.Yes

    def write(self, job: Job) -> None:
        """Do a job behind the window, and remember where."""
        QSettings("rsegen", "rsegen").setValue(self._words.key, str(job.folder.absolute()))
        self.run = run = Run(job, force=self._force)
        self.bar.setRange(0, job.steps if 1 < job.steps < 2**31 else 0)
        self.bar.setValue(0)
        run.progressed.connect(self.bar.setValue)
        run.succeeded.connect(self._tell)
        run.cancelled.connect(self._tell)
        run.failed.connect(self.complaint.say)
        run.finished.connect(self._show_state)
        self.complaint.say("")
        self._outcome.setText("")
        run.start()
        self._show_state()

    def open_folder(self) -> None:
        """Show what was written in the desktop's own program."""
        if self.written:
            QDesktopServices.openUrl(QUrl.fromLocalFile(str(self.written.absolute())))

    def end(self) -> None:
        """Stop what is being written, and wait for it."""
        self._stop()
        if self.run:
            self.run.wait()

    def _make_widgets(self) -> None:
        words = self._words
        last = QSettings("rsegen", "rsegen").value(words.key)
        tip = f"the folder to write the {words.what} into; it is made if it is not there"
        self._line = named(QLineEdit(str(last or words.usual)), "folder", title="output folder", tip=tip)
        self._choose = named(QToolButton(), "choose_folder", title="look for a folder", tip="look for one")
        self._choose.setText("...")
        self.complaint = Notice("folder_complaint")
        self.start = named(QPushButton(words.button), "start", tip=words.tip)
        self.cancel = named(QPushButton("Cancel"), "cancel", tip="stop; what is complete stays")
        self.bar = named(QProgressBar(), "progress")
        self._outcome = named(QLabel(wordWrap=True), "outcome")
        self._open = named(QPushButton("Open the folder"), "open_folder", tip="show what was written")
        for button in (self.cancel, self._open):
            button.setAutoDefault(False)

    def _lay_out(self) -> None:
        label = QLabel("Folder")
        label.setBuddy(self._line)
        self._outcome.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)
        self.column = column = QVBoxLayout(self)
        column.addLayout(row_of(label, self._line, self._choose))
        column.addWidget(self.complaint)
        row = row_of(self.start, *self._beside, self.bar, self.cancel)
        row.setStretch(0, 1)
        column.addLayout(row)
        column.addLayout(row_of(self._outcome, self._open))
        self._show_state()

    def _refuse(self) -> None:
        if not self._line.text().strip():
            raise OutputError(f"give a folder to write the {self._words.what} into, as {self._words.usual}")
        refuse_not_a_folder(self.folder)

    def _ask(self) -> None:
        title = f"Where to write the {self._words.what}"
        folder = QFileDialog.getExistingDirectory(self, title, str(self.folder.absolute()))
        if folder:
            self.folder = Path(folder)

    def _stop(self) -> None:
        if self.run:
            self.run.requestInterruption()

    def _tell(self, text: str) -> None:
        self.written = self.run.job.folder if self.run else None
        self._outcome.setText(text)

    def _show_state(self) -> None:
        """The button, or a bar and Cancel; what came of the last run, if any."""
        for widget, shown in (
            *((widget, not self.busy) for widget in (self.start, *self._beside)),
            (self.cancel, self.busy),
            (self.bar, self.busy),
            (self._outcome, bool(self._outcome.text())),
            (self._open, bool(self._outcome.text()) and self.written is not None),
        ):
            widget.setVisible(shown)
        self.changed.emit()
