"""The widgets that a user can reach, and what they are called in the log."""

from __future__ import annotations

from random import Random

from PySide6.QtCore import QPoint
from PySide6.QtWidgets import QApplication, QMenu, QWidget
from shiboken6 import isValid

from rsegen.gui.window import Window


def is_of_a_folder(widget: QWidget) -> bool:
    return widget.objectName() == "folder"


def front_dialog() -> QWidget | None:
    """The dialog that keeps the mouse and the keyboard from the window."""
    return QApplication.activeModalWidget()


def targets(window: Window) -> list[QWidget]:
    """The widgets that a mouse reaches: those of the modal dialog, or else of the window."""
    inside = QApplication.activePopupWidget() or front_dialog() or window
    found = [each for each in inside.findChildren(QWidget) if each.isVisible() and each.isEnabled()]
    usable = [each for each in found if not each.visibleRegion().isEmpty() and not _opens_a_folder(each)]
    return usable or [inside]


def _opens_a_folder(widget: QWidget) -> bool:
    return widget.objectName() == "open_folder" or isinstance(widget, QMenu)


def point_on(widget: QWidget, random: Random) -> QPoint:
    return QPoint(random.randrange(max(widget.width(), 1)), random.randrange(max(widget.height(), 1)))


def name_of(widget: QWidget) -> str:
    parent = widget.parentWidget()
    return widget.objectName() or f"{type(widget).__name__} in {name_of(parent) if parent else 'nothing'}"


def is_there(widget: QWidget) -> bool:
    """Whether Qt has not deleted it yet."""
    return isValid(widget) and widget.isEnabled()
