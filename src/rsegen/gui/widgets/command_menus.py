"""Menu entries that are enabled only while they can be done."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from PySide6.QtGui import QAction, QKeySequence
from PySide6.QtWidgets import QMenu, QWidget


def _always() -> bool:
    return True


class Command(NamedTuple):
    """What a menu entry is called, what it does, its shortcut, and when it is enabled."""

    text: str
    run: Callable[[], object]
    keys: QKeySequence.StandardKey | str = ""
    is_possible: Callable[[], bool] = _always


class CommandMenus:
    """The commands of all menus as actions of a widget, in which their shortcuts work.

    `before` is called before a command runs; it may make the command impossible, which is then not run.
    """

    def __init__(self, parent: QWidget, before: Callable[[], object] = lambda: None) -> None:
        self._parent, self._before = parent, before
        self._actions: list[tuple[QAction, Callable[[], bool]]] = []

    def add(self, menu: QMenu, *commands: Command) -> None:
        """Add commands at the end of a menu."""
        for command in commands:
            action = QAction(command.text, self._parent)
            action.setObjectName(command.text.replace("&", "").rstrip("."))
            action.setShortcut(QKeySequence(command.keys))
            action.triggered.connect(lambda _=False, command=command: self._run(command))
            menu.addAction(action)
            self._actions.append((action, command.is_possible))

    def _run(self, command: Command) -> None:
        self._before()
        if command.is_possible():
            command.run()

    def refresh(self) -> None:
        """Enable the commands that can be done now."""
        for action, is_possible in self._actions:
            action.setEnabled(is_possible())
