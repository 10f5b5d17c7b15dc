"""Answers the dialogs that wait for an answer: a timer acts on them, as nothing else runs meanwhile."""

from __future__ import annotations

from random import Random

from PySide6.QtCore import QObject, Qt, QTimer
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QAbstractButton,
    QApplication,
    QDialog,
    QFileDialog,
    QLineEdit,
    QMessageBox,
    QPlainTextEdit,
)

from tests.gui.random_actions.texts import FILES, TEXTS, numbers

_TRIES = 6
"""A dialog that was answered this often and is still open is cancelled."""


class Answers(QObject):
    """Answers each dialog that an action opens; `log` gets what was answered."""

    def __init__(self, log: list[str]) -> None:
        super().__init__()
        self._log, self._random = log, numbers(0)
        self._tries: dict[int, int] = {}
        self._round = 0

    def begin(self, random: Random) -> None:
        """Answer from now on, by these random numbers."""
        self._random, self._tries, self._round = random, {}, self._round + 1
        self._wait(self._round)

    def end(self) -> None:
        """Leave dialogs as they are: those that wait for no answer are acted on like the window."""
        self._round += 1

    def _wait(self, number: int) -> None:
        """Look again in a moment; each time by another timer, as Qt lets none run while its slot does."""
        QTimer.singleShot(1, self, lambda: self._answer(number))

    def _answer(self, number: int) -> None:
        if number != self._round:
            return
        self._wait(number)
        dialog = QApplication.activeModalWidget()
        if not isinstance(dialog, QDialog) or not _waits(dialog):
            return
        tries = self._tries[id(dialog)] = self._tries.get(id(dialog), 0) + 1
        self._log.append(f"  answers {type(dialog).__name__} {dialog.windowTitle()!r}")
        dialog.reject() if tries > _TRIES else self._act(dialog)

    def _act(self, dialog: QDialog) -> None:
        random = self._random
        if isinstance(dialog, QMessageBox):
            _press(random.choice(dialog.buttons()))
        elif isinstance(dialog, QFileDialog):
            self._type(dialog.findChildren(QLineEdit)[0], random.choice(FILES))
            QTest.keyClick(dialog, random.choice([Qt.Key.Key_Return, Qt.Key.Key_Return, Qt.Key.Key_Escape]))
        else:
            for page in dialog.findChildren(QPlainTextEdit):
                self._type(page, random.choice(TEXTS))
            for field in dialog.findChildren(QLineEdit):
                self._type(field, random.choice(TEXTS))
            QTest.keyClick(dialog, random.choice([Qt.Key.Key_Return, Qt.Key.Key_Escape]))
            if buttons := [each for each in dialog.findChildren(QAbstractButton) if each.isVisible()]:
                _press(random.choice(buttons))

    def _type(self, field: QLineEdit | QPlainTextEdit, text: str) -> None:
        self._log.append(f"    types {text!r}")
        field.selectAll()
        QApplication.clipboard().setText(text)
        field.paste()


def _waits(dialog: QDialog) -> bool:
    """Whether the code that opened it waits for it, as for those of `exec`; the others are window-modal."""
    return dialog.windowModality() == Qt.WindowModality.ApplicationModal


def _press(button: QAbstractButton) -> None:
    if button.isVisible() and button.isEnabled():
        QTest.mouseClick(button, Qt.MouseButton.LeftButton)
