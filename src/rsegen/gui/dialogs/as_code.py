"""The dialog that shows a recipe as a command line and as Python code, to be copied."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QFontDatabase, QGuiApplication
from PySide6.QtWidgets import QDialog, QDialogButtonBox, QLabel, QPlainTextEdit, QPushButton, QVBoxLayout, QWidget

from rsegen.gui.model.as_code import command_line, python_code
from rsegen.gui.model.jobs import WorldsJob
from rsegen.gui.widgets.layouts import row_of
from rsegen.gui.widgets.named import named


class CodeDialog(QDialog):
    """The command line and the Python code that write the same maps as Start."""

    def __init__(self, job: WorldsJob, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        named(self, "code_dialog")
        self.setWindowTitle("Command line and Python code")
        self.resize(760, 560)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        column = QVBoxLayout(self)
        for title, name, text, share in (
            ("Command line", "command_line", command_line(job.recipe, str(job.folder), sheets=job.sheets), 2),
            ("Python code", "python_code", python_code(job.recipe, str(job.folder), sheets=job.sheets), 5),
        ):
            page = _page(name, text)
            copy = named(QPushButton("Copy"), f"copy_{name}", title=f"copy the {title}", tip="copy the whole text")
            copy.setAutoDefault(False)
            copy.clicked.connect(lambda _=False, text=text: QGuiApplication.clipboard().setText(text))
            head = row_of(QLabel(title), copy)
            head.insertStretch(1, 1)
            column.addLayout(head)
            column.addWidget(page, stretch=share)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        buttons.rejected.connect(self.reject)
        column.addWidget(buttons)


def _page(name: str, text: str) -> QPlainTextEdit:
    """A read-only text in a monospaced font."""
    page = named(QPlainTextEdit(text), name)
    page.setReadOnly(True)
    page.setTabChangesFocus(True)
    page.setFont(QFontDatabase.systemFont(QFontDatabase.SystemFont.FixedFont))
    page.setMinimumHeight(5 * page.fontMetrics().lineSpacing())
    return page
