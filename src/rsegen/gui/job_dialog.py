"""A dialog that writes files of maps: what is particular to them, then a folder and a run."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDialog, QDialogButtonBox, QVBoxLayout, QWidget

from rsegen.errors import ParameterError
from rsegen.gui.editors import named
from rsegen.gui.jobs import Job
from rsegen.gui.run_form import RunForm, Words


class JobDialog(QDialog):
    """`body` is what is chosen, and cannot be changed during a run; closing it stops the run."""

    def __init__(self, name: str, title: str, words: Words, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        named(self, name)
        self.setWindowTitle(title)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.form = RunForm(words)
        self.form.start.setDefault(True)
        self.form.start.clicked.connect(self._write)
        self.form.changed.connect(self.show_state)
        self.form.column.setContentsMargins(0, 0, 0, 0)

    def job(self) -> Job:
        """What stands in the dialog; a ParameterError where that cannot be."""
        raise NotImplementedError

    def lay_out(self, body: QWidget, stretch: int = 0) -> None:
        """The body, the form, and Close."""
        self._body = body
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        buttons.button(QDialogButtonBox.StandardButton.Close).setAutoDefault(False)
        buttons.rejected.connect(self.reject)
        column = QVBoxLayout(self)
        column.setSpacing(12)
        column.addWidget(body, stretch)
        column.addWidget(self.form)
        column.addWidget(buttons)

    def show_state(self) -> None:
        """What can be done."""
        self._body.setEnabled(not self.form.busy)

    def done(self, result: int) -> None:
        """Stop what is being written."""
        self.form.end()
        super().done(result)

    def _write(self) -> None:
        try:
            job = self.job()
        except ParameterError as error:
            self.form.complaint.say(str(error))
            return
        if self.form.is_free_for(job):
            self.form.write(job)
