"""A dialog that runs a job: its options, an output folder, and progress."""

from __future__ import annotations

from PySide6.QtCore import QPoint, QSize, Qt, QTimer
from PySide6.QtWidgets import QDialog, QDialogButtonBox, QVBoxLayout, QWidget

from rsegen.errors import RsegenError
from rsegen.gui.model.jobs import Job
from rsegen.gui.widgets.named import named
from rsegen.gui.widgets.run_form import FormTexts, RunForm


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
