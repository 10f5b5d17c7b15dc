"""Waiting for what a window does in the background."""

from __future__ import annotations

from collections.abc import Callable

from tests.support import patience


def until(holds: Callable[[], bool], every: int = 25) -> None:
    """Let the window work, with short rests in which threads get their turn, until something holds."""
    from PySide6.QtTest import QTest

    def rest() -> None:
        QTest.qWait(every)
        patience.rest()

    patience.until(holds, rest=rest)
