"""Start: where the maps go, how far they are, and what came of them."""

from __future__ import annotations

from itertools import islice
from pathlib import Path

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

from rsegen.errors import OutputError
from rsegen.gui.editors import named
from rsegen.gui.layout import row_of
from rsegen.gui.notice import Notice
from rsegen.gui.running import Generation
from rsegen.recipe import Recipe
from rsegen.writer import refuse_not_a_folder

WORLDS = "worlds"
"""Where maps are written, until a person says otherwise."""

_LOOKED_FOR = 10_000
"""So many maps are looked for, to ask before they are replaced."""


class StartForm(QWidget):
    """A folder, and a run that writes into it; `changed` tells that one has begun or ended."""

    changed = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.generation: Generation | None = None
        self.written: Path | None = None
        self._force = False
        self._make_widgets()
        self._lay_out()
        self._choose.clicked.connect(self._ask)
        self._line.textEdited.connect(lambda: self.complaint.say(""))
        self.cancel.clicked.connect(self._stop)
        self._open.clicked.connect(self.open_folder)

    @property
    def folder(self) -> Path:
        """Where the maps go, as it stands in the line."""
        return Path(self._line.text().strip()).expanduser()

    @folder.setter
    def folder(self, folder: Path) -> None:
        self._line.setText(str(folder))
        self.complaint.say("")

    @property
    def busy(self) -> bool:
        """Whether maps are being written."""
        return self.generation is not None and self.generation.isRunning()

    def is_free_for(self, recipe: Recipe) -> bool:
        """Whether the maps of a recipe may be written there: asks where they are there already, says what is wrong."""
        try:
            self._refuse()
        except OutputError as error:
            self.complaint.say(str(error))
            return False
        names = (self.folder / recipe.map_name(index) for index in islice(recipe.indices, _LOOKED_FOR))
        self._force = any(name.exists() for name in names)
        question = f"{self.folder} holds maps of the name {recipe.name} already. Replace them?"
        return not self._force or QMessageBox.question(self, "rsegen", question) == QMessageBox.StandardButton.Yes

    def write(self, recipe: Recipe) -> None:
        """Write the maps of a recipe behind the window, and remember where."""
        folder = self.folder
        QSettings("rsegen", "rsegen").setValue("folder", str(folder.absolute()))
        self.generation = run = Generation(recipe, folder, force=self._force)
        self.bar.setRange(0, recipe.maps if 1 < recipe.maps < 2**31 else 0)
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
        """Show the maps that were written in the desktop's own program."""
        if self.written:
            QDesktopServices.openUrl(QUrl.fromLocalFile(str(self.written.absolute())))

    def end(self) -> None:
        """Stop what is being written, and wait for it."""
        self._stop()
        if self.generation:
            self.generation.wait()

    def _make_widgets(self) -> None:
        last = QSettings("rsegen", "rsegen").value("folder")
        tip = "the folder to write the maps into; it is made if it is not there"
        self._line = named(QLineEdit(str(last or WORLDS)), "folder", title="output folder", tip=tip)
        self._choose = named(QToolButton(), "choose_folder", title="look for a folder", tip="look for one")
        self._choose.setText("...")
        self.complaint = Notice("folder_complaint")
        self.start = named(QPushButton("Start"), "start", tip="write the maps into the folder (F5)")
        self.cancel = named(QPushButton("Cancel"), "cancel", tip="stop; the maps that are complete stay")
        self.bar = named(QProgressBar(), "progress")
        self._outcome = named(QLabel(wordWrap=True), "outcome")
        self._open = named(QPushButton("Open the folder"), "open_folder", tip="show the maps that were written")

    def _lay_out(self) -> None:
        label = QLabel("Folder")
        label.setBuddy(self._line)
        self._outcome.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)
        column = QVBoxLayout(self)
        column.addLayout(row_of(label, self._line, self._choose))
        column.addWidget(self.complaint)
        column.addLayout(row_of(self.start, self.bar, self.cancel))
        column.addLayout(row_of(self._outcome, self._open))
        self._show_state()

    def _refuse(self) -> None:
        if not self._line.text().strip():
            raise OutputError("give a folder to write the maps into, as worlds")
        refuse_not_a_folder(self.folder)

    def _ask(self) -> None:
        folder = QFileDialog.getExistingDirectory(self, "Where to write the maps", str(self.folder.absolute()))
        if folder:
            self.folder = Path(folder)

    def _stop(self) -> None:
        if self.generation:
            self.generation.requestInterruption()

    def _tell(self, text: str) -> None:
        self.written = self.generation.folder if self.generation else None
        self._outcome.setText(text)

    def _show_state(self) -> None:
        """Start, or a bar and Cancel; what came of the last run, if any."""
        for widget, shown in (
            (self.start, not self.busy),
            (self.cancel, self.busy),
            (self.bar, self.busy),
            (self._outcome, bool(self._outcome.text())),
            (self._open, bool(self._outcome.text()) and self.written is not None),
        ):
            widget.setVisible(shown)
        self.changed.emit()
