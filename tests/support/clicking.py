"""Hands for the tests of the window: widgets found by name, clicked, typed into, and questions answered."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, TypeVar

from tests.support.waiting import MINUTES, exposed

if TYPE_CHECKING:
    from PySide6.QtWidgets import QMessageBox, QWidget

    from rsegen.gui.window import Window

Kind = TypeVar("Kind", bound="QWidget")


@contextmanager
def shown(window: Window) -> Iterator[None]:
    """The window on the screen, as long as this lasts, and then closed without a question."""
    from rsegen.gui.model.session import Session

    window.show()
    exposed(window)
    yield
    window.document.open(Session.new())
    window.close()


def find(within: QWidget, kind: type[Kind], name: str) -> Kind:
    """The one widget of a name."""
    (found,) = within.findChildren(kind, name)
    return found


def click(within: QWidget, name: str) -> None:
    """Press a button with the mouse; a check box on its box."""
    from PySide6.QtCore import QPoint, Qt
    from PySide6.QtTest import QTest
    from PySide6.QtWidgets import QAbstractButton, QCheckBox

    button = find(within, QAbstractButton, name)
    where = QPoint(8, button.height() // 2) if isinstance(button, QCheckBox) else button.rect().center()
    QTest.mouseClick(button, Qt.MouseButton.LeftButton, pos=where)


def typed(within: QWidget, name: str, text: str) -> None:
    """Type a text in the place of the one that is there."""
    from PySide6.QtCore import Qt
    from PySide6.QtTest import QTest
    from PySide6.QtWidgets import QAbstractSpinBox, QLineEdit, QWidget

    field = find(within, QWidget, name)
    assert isinstance(field, (QLineEdit, QAbstractSpinBox))
    field.selectAll()
    QTest.keyClick(field, Qt.Key.Key_Delete)
    QTest.keyClicks(field, text)


def active(window: Kind) -> Kind:
    """The window, once it hears its shortcuts."""
    from PySide6.QtTest import QTest

    window.activateWindow()
    assert QTest.qWaitForWindowActive(window, MINUTES)
    return window


def said(within: QWidget, name: str) -> str:
    """What a label says; nothing where it is not seen."""
    from PySide6.QtWidgets import QLabel

    label = find(within, QLabel, name)
    return label.text() if label.isVisible() else ""


def answer(button: QMessageBox.StandardButton) -> list[str]:
    """Give this answer to the question that comes next, which then stands in the list."""
    from PySide6.QtCore import Qt, QTimer
    from PySide6.QtTest import QTest
    from PySide6.QtWidgets import QApplication, QMessageBox

    asked: list[str] = []

    def press() -> None:
        box = QApplication.activeModalWidget()
        if not isinstance(box, QMessageBox):
            QTimer.singleShot(50, press)
            return
        asked.append(box.text())
        QTest.mouseClick(box.button(button), Qt.MouseButton.LeftButton)

    QTimer.singleShot(50, press)
    return asked
