"""Waiting for what a window does in threads."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from tests.support import patience

if TYPE_CHECKING:
    from PySide6.QtWidgets import QWidget

MINUTES = 600_000
"""For Qt's own waiting, in milliseconds: no test fails for being slow, only for hanging."""


def until(holds: Callable[[], bool], every: int = 25) -> None:
    """Let the window work, with short rests in which threads get their turn, until something holds."""
    from PySide6.QtTest import QTest

    def rest() -> None:
        QTest.qWait(every)
        patience.rest()

    patience.until(holds, rest=rest)


def exposed(widget: QWidget) -> None:
    """Wait until a window is on the screen."""
    from PySide6.QtTest import QTest

    assert QTest.qWaitForWindowExposed(widget, MINUTES)
